"""What stands against adding effects of a diagnosis to a rig file, and what a person should know who adds them."""

from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from pathlib import Path

from updamp.diagnosis.verdict import Verdict
from updamp.effects.own_effects import own_effect
from updamp.effects.placed import effect_called
from updamp.rig.effects import RigEffect


def not_fitted(verdict: Verdict, names: Sequence[str], source: Path) -> Iterator[str]:
    candidates = {candidate.name: candidate for candidate in verdict.candidates}
    fitted = [name for name, candidate in candidates.items() if candidate.parameters]
    for name in names:
        if name not in candidates:
            close = get_close_matches(name, candidates, n=1)
            instead = f"did you mean {close[0]}?" if close else f"it looked at {', '.join(candidates) or 'none'}"
            yield f"{name}: {source} has no such effect; {instead}"
        elif not candidates[name].parameters:
            yield (
                f"{name}: not refitted in {source} ({candidates[name].reason or 'no reason given'}), so it has no "
                f"values; fitted were {', '.join(fitted) or 'none'}"
            )


def of_rig(verdict: Verdict, source: Path, rig: str) -> None:
    """raises: ValueError where the diagnosis is of another rig: its values mean nothing here"""
    of = verdict.provenance.get("rig", rig)  # older ones do not say
    if of != rig:
        raise ValueError(
            f"{source}: is a diagnosis of the rig '{of}', and this is '{rig}'; give that of this rig with --from"
        )


def already_there(present: Sequence[RigEffect], names: Sequence[str], rig: Path, replace: bool) -> Iterator[str]:
    """An effect at its null values waits to be fitted: it may be replaced unasked."""
    for effect in present:
        if effect.name in names and not replace and not _absent(effect):
            values = ", ".join(
                f"{name} {value:g} {effect.units[name]}".rstrip() for name, value in effect.values.items()
            )
            yield (
                f"{effect.name}: {rig} has it already ({values}); to put the new values in their place give --replace, "
                f"to take it off: updamp remove {rig} {effect.name}"
            )


def _absent(effect: RigEffect) -> bool:
    defined = own_effect(effect.file) if effect.file else effect_called(effect.name)
    return defined is not None and dict(effect.values) == defined.at_null()


def unknown(verdict: Verdict, names: Sequence[str], own: Sequence[str]) -> Iterator[str]:
    looked_at = {candidate.name for candidate in verdict.candidates}
    for name in names:
        if name in looked_at and effect_called(name) is None and name not in own:
            yield f"{name}: neither in the catalogue nor in the rig file; name the Python file that defines it: --file"


def calibration_missing(verdict: Verdict, names: Sequence[str], wanted: bool) -> Iterator[str]:
    if not wanted:
        return
    if not verdict.calibration:
        yield "--with-calibration: the diagnosis hands on none; leave it out, `updamp compare` calibrates anew"
    elif set(names) != set(verdict.effects):
        yield (
            f"--with-calibration: it was fitted together with {', '.join(verdict.effects) or 'no effect'}; "
            "add just that, or leave it out: `updamp compare` calibrates anew"
        )


def name_in_use(out: Path, rig: Path, replace: bool) -> Iterator[str]:
    """The rig file itself may be named as the new one: who does so wants it changed."""
    if out.exists() and not replace and out.resolve() != rig.resolve():
        yield f"{out}: is there already; give another name with --out, or --replace to put the new one in its place"


def notes(verdict: Verdict, names: Sequence[str]) -> Iterator[str]:
    for candidate in verdict.candidates:
        if candidate.name in names and not candidate.accepted:
            yield f"{candidate.name} was not accepted by the diagnosis: {candidate.reason or 'no reason given'}"
    # which look alike to first order is no matter here: the diagnosis has fitted them, and says what fits do not tell
    chosen = [name for name in names if name in verdict.group]
    others = [name for name in verdict.group if name not in chosen]
    if len(chosen) > 1:
        yield f"the data cannot tell {' and '.join(chosen)} apart: take one of them off"
    if chosen and others:
        yield f"the data cannot tell {' and '.join(chosen)} from {', '.join(others)}"
