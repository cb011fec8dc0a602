"""`updamp add` and `updamp remove`: a rig file with effects that a diagnosis found, or without them."""

import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import date
from pathlib import Path

from updamp.diagnosis.verdict import VERDICT_JSON, FittedParameter, Verdict
from updamp.effects.own_effects import own_effect
from updamp.model.calibration import present_name
from updamp.model.rig_files import load_any
from updamp.rig.errors import RigError
from updamp.workflow import rig_text
from updamp.workflow.add_checks import (
    already_there,
    calibration_missing,
    name_in_use,
    not_fitted,
    notes,
    of_rig,
    unknown,
)
from updamp.workflow.fitted_effects import fitted_effects
from updamp.workflow.history import Errors, HistoryStep, data_hash, read_history, write_history
from updamp.workflow.rig_text import EffectText


@dataclass(frozen=True)
class AddOptions:
    """out: the new rig file, None for a name made from the old one's and the effects'
    replace: put new values in the place of an effect's that is there, and a new file in the place of `out`
    with_calibration: take along what was calibrated together with the effects
    own: files of the user's own effects, for names that are not in the catalogue
    """

    out: Path | None = None
    replace: bool = False
    with_calibration: bool = False
    own: tuple[Path, ...] = ()


@dataclass(frozen=True)
class Changed:
    """The new rig file, the step in its history, and what a person should know about it."""

    rig: Path
    step: HistoryStep
    notes: tuple[str, ...] = ()


def add(rig: Path, names: Sequence[str], folder: Path, options: AddOptions | None = None) -> Changed:
    """Write a rig file with effects at the values that a diagnosis fitted, and its history.

    names: of effects; none for those that the diagnosis identified
    folder: with the diagnosis.json of `updamp diagnose`
    raises: ValueError with every problem found, one a line; RigError for a rig file that cannot be used
    """
    options = options or AddOptions()
    loaded = load_any(rig)
    present = loaded.effects
    source, verdict = _diagnosis(rig, folder)
    of_rig(verdict, source, loaded.name)
    names = tuple(dict.fromkeys(names)) or _identified(verdict, source)
    own = {own_effect(path).name: path for path in options.own}
    out = options.out or rig.with_name(f"{rig.stem}+{'+'.join(names)}.toml")
    kept = frozenset(effect.name for effect in present) - frozenset(names)
    fitted = fitted_effects(verdict, names, kept)
    problems = [
        *not_fitted(verdict, [name for name in names if name not in fitted.parameters], source),
        *already_there(present, names, rig, options.replace),
        *unknown(verdict, names, [*own, *(effect.name for effect in present)]),
        *calibration_missing(verdict, names, options.with_calibration),
        *name_in_use(out, rig, options.replace),
    ]
    if problems:
        raise ValueError("\n".join(problems))
    where = f"{_measurement(verdict)}, {_day(verdict, source)}"
    text = rig_text.moved(rig.read_text(encoding="utf-8"), rig.parent, out.parent)
    for name in names:
        file = os.path.relpath(own[name], out.parent) if name in own else ""
        text = rig_text.with_effect(text, _stated(name, fitted.parameters[name], where, file))
    if options.with_calibration:
        factors = {present_name(entry.name): entry.after for entry in verdict.calibration}
        text = rig_text.with_calibration(text, factors, f"fitted together with {', '.join(names)} to {where}")
    step = _added(verdict, rig, out, names, tuple(effect.name for effect in present), _day(verdict, source))
    _write(rig, out, text, step)
    return Changed(out, step, (*notes(verdict, names), *fitted.notes(names, kept)))


def remove(rig: Path, names: Sequence[str], out: Path | None = None, replace: bool = False) -> Changed:
    """Write a rig file without some of its effects, and its history.

    names: of effects; "calibration" for the table of that name
    replace: put the new file in the place of `out`
    raises: ValueError with every problem found, one a line; RigError for a rig file that cannot be used without them
    """
    text = rig.read_text(encoding="utf-8")
    there, is_calibrated = _removable(rig, text, names)
    removable = (*there, *(("calibration",) if is_calibrated else ()))
    names = tuple(dict.fromkeys(names))
    out = out or rig.with_name(f"{rig.stem}-{'-'.join(names)}.toml")
    has = f"it has {', '.join(removable)}" if removable else "it has no effects"
    problems = [f"{rig}: {name} is not there; {has}" for name in names if name not in removable]
    if problems := [*problems, *name_in_use(out, rig, replace)]:
        raise ValueError("\n".join(problems))
    text = rig_text.without_effects(rig_text.moved(text, rig.parent, out.parent), names)
    if "calibration" in names:
        text = rig_text.without_calibration(text)
    history, left = read_history(rig), tuple(name for name in there if name not in names)
    step = HistoryStep(
        "removed", tuple(names), left, history.reached_with(there), history.reached_with(left), float("nan"),
        out.name, _relative_path(rig, out), "", "", date.today().isoformat(),
    )  # fmt: skip
    _write(rig, out, text, step)
    stays = is_calibrated and "calibration" not in names
    return Changed(out, step, ("the calibration stays: to take it off too, name calibration",) if stays else ())


def _removable(rig: Path, text: str, names: Sequence[str]) -> tuple[tuple[str, ...], bool]:
    """Names of its effects, and whether it is calibrated. An effect that the file cannot be read with, such as one of
    which the Python file is gone, can be taken off too: the new file is read before it appears.

    raises: RigError for a rig file that cannot be read for anything else
    """
    try:
        loaded = load_any(rig)
    except RigError:
        with suppress(ValueError, KeyError):
            there = rig_text.effect_names(text)
            if set(names) & set(there):
                return there, rig_text.is_calibrated(text)
        raise
    return tuple(effect.name for effect in loaded.effects), bool(loaded.calibration)


# --- what a diagnosis says ---


def _diagnosis(rig: Path, folder: Path) -> tuple[Path, Verdict]:
    source = folder / "diagnosis.json"
    if not source.is_file():
        raise ValueError(f"{source}: no such file; make it with: updamp diagnose {rig} MEASUREMENT --out {folder}")
    return source, VERDICT_JSON.read(source)


def _identified(verdict: Verdict, source: Path) -> tuple[str, ...]:
    if verdict.verdict == "inseparable":
        together = f"{' '.join(verdict.outright)} and " if verdict.outright else ""
        raise ValueError(
            f"{source}: the data do not tell which of {', '.join(verdict.group)} is missing; name what is to be added: "
            f"{together}one of them"
        )
    if not verdict.effects:
        fitted = ", ".join(c.name for c in verdict.candidates if c.parameters) or "none"
        raise ValueError(
            f"{source}: no effect was identified ({verdict.verdict}); name one of those that were fitted: {fitted}"
        )
    return verdict.effects


# --- what is written ---


def _measurement(verdict: Verdict) -> str:
    return verdict.provenance.get("measurement", "a measurement that is not named")


def _day(verdict: Verdict, source: Path) -> str:
    return verdict.provenance.get("date") or date.fromtimestamp(source.stat().st_mtime).isoformat()


def _stated(name: str, parameters: Sequence[FittedParameter], where: str, file: str) -> EffectText:
    intervals = ", ".join(
        f"{p.name} {p.lower:.3g} to {p.upper:.3g} {p.unit}".rstrip() for p in parameters if p.lower < p.upper
    )
    origin = f"fitted to {where}" + (f"; 95 %: {intervals}" if intervals else "")
    return EffectText(name, {p.name: _value(p) for p in parameters}, origin, file)


def _value(p: FittedParameter) -> str | float:
    """Six digits, unless these would leave the bounds."""
    short = float(f"{p.value:.6g}")
    value = short if p.lower_bound <= short <= p.upper_bound else p.value
    return f"{value!r} {p.unit}" if p.unit else value


def _added(verdict: Verdict, rig: Path, out: Path, names: Sequence[str], there: Sequence[str], day: str) -> HistoryStep:
    new = (*there, *(name for name in names if name not in there))
    before, after = _errors(verdict, frozenset(names), frozenset(there) - frozenset(names))
    return HistoryStep(
        "added", tuple(names), new, before, after, verdict.error.repeatability, out.name, _relative_path(rig, out),
        verdict.provenance.get("measurement", ""), data_hash(verdict.provenance), day,
    )  # fmt: skip


def _errors(verdict: Verdict, added: frozenset[str], kept: frozenset[str]) -> tuple[Errors, Errors]:
    """Before and after; of a step that the diagnosis did not make only the gain on held-out data is known.

    kept: in the rig file already. Where the diagnosis made a step with just these, or fitted them, it was made before
    they were taken up; else it began from them.
    """
    error = verdict.error
    steps: Mapping[frozenset[str], Errors] = {
        **{frozenset(e.effects): Errors(e.misfit, e.held_out) for e in verdict.explanations},
        frozenset(): Errors(error.before, error.held_out_before),
        frozenset(verdict.effects): Errors(error.after, error.held_out_after),
        **{frozenset(step.effects): Errors(step.error, step.held_out) for step in verdict.history},
    }
    base = kept if kept in steps else frozenset()
    before = steps[base]
    if base | added in steps:
        return before, steps[base | added]
    alone = [candidate for candidate in verdict.candidates if {candidate.name} == added]
    gain = alone[0].held_out_gain if alone and not base else float("nan")
    return before, Errors(held_out=before.held_out * (1 - gain))


def _relative_path(rig: Path, out: Path) -> str:
    return os.path.relpath(rig.resolve(), out.resolve().parent)


def _write(rig: Path, out: Path, text: str, step: HistoryStep) -> None:
    """The new file appears once it has been read back without a problem."""
    out.parent.mkdir(parents=True, exist_ok=True)
    temporary = out.with_name(f".{out.stem}.{os.getpid()}.toml")
    try:
        temporary.write_text(text, encoding="utf-8")
        _check(temporary, out)
        history = read_history(rig).then(step)
        os.replace(temporary, out)
    finally:
        temporary.unlink(missing_ok=True)
    write_history(out, history)


def _check(written: Path, out: Path) -> None:
    try:
        load_any(written)
    except RigError as error:
        raise RigError(str(error).replace(str(written), str(out))) from error
