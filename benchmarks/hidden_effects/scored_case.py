"""One case with its truth, its verdict and what comes of comparing them."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Any

from updamp.benchmarks.hidden_effects.judgement import Called, Mark, judged
from updamp.benchmarks.hidden_effects.kinds_of_test import EASY
from updamp.benchmarks.hidden_effects.layout import Layout, read
from updamp.benchmarks.virtual_rig.laboratory import HIDDEN
from updamp.diagnosis.verdict import VERDICT_JSON, Candidate, ErrorReached, Verdict
from updamp.effects.catalogue import CATALOGUE

# Fixed before any verdict.
SCORE, VISIBILITY = 6.0, 0.2
ABLATIONS = "ablations.json"
_IN_PROVENANCE = "ablation "


@dataclass(frozen=True)
class Detectability:
    """How well a hidden effect shows. score: in standard deviations; nan where nothing is known"""

    score: float
    visibility: float

    @property
    def detectable(self) -> bool | None:
        """None where nothing is known."""
        if not (isfinite(self.score) and isfinite(self.visibility)):
            return None
        return self.score >= SCORE and self.visibility >= VISIBILITY


@dataclass(frozen=True)
class Recovered:
    """A fitted parameter beside the truth. error: off by so much of its distance from the null value"""

    effect: str
    name: str
    truth: float
    value: float
    lower: float
    upper: float
    error: float
    inside: bool


@dataclass(frozen=True)
class ScoredCase:
    """truth: the laboratory's names of what is hidden, at `strength` where it is one
    by_laboratory, by_diagnosis: of each of these
    recovered: parameters of those that were refitted; ablations: what others would have said, and their marks
    test: kind of test; seconds: on the clock; processor: of one core, as a busy machine does not change much
    """

    case: str
    kind: str
    strength: str
    truth: tuple[str, ...]
    repeats: str
    called: Called
    mark: Mark
    error: ErrorReached
    by_laboratory: Mapping[str, Detectability]
    by_diagnosis: Mapping[str, Detectability]
    recovered: tuple[Recovered, ...]
    ablations: Mapping[str, tuple[Called, Mark]]
    seconds: float
    processor: float
    test: str = EASY.name

    @property
    def detectable(self) -> bool | None:
        """Every hidden effect is: by the laboratory's own curves where that was computed, by the diagnosis otherwise;
        None where neither is known or nothing is hidden."""
        return _all_detectable(self.by_laboratory if self.by_laboratory else self.by_diagnosis)

    @property
    def detectable_by_diagnosis(self) -> bool | None:
        return _all_detectable(self.by_diagnosis)


def _all_detectable(effects: Mapping[str, Detectability]) -> bool | None:
    each = [one.detectable for one in effects.values()]
    if not each or None in each:
        return None
    return all(each)


def scored(layout: Layout, truth: Mapping[str, Any]) -> ScoredCase | None:
    """None where there is no verdict yet. raises: ValueError naming a file that cannot be read"""
    name = truth["case"]
    folder = layout.verdict(name)
    ran = read(folder / "run.json")
    if ran is None:
        return None
    verdict = VERDICT_JSON.read(folder / "diagnosis.json")
    hidden = tuple(truth["effects"])
    in_catalogue = {name: HIDDEN[name].catalogue_name for name in hidden}
    called = Called(verdict.verdict, verdict.effects, verdict.group)
    candidates = {c.name: c for c in verdict.candidates}
    others = ablations_of(verdict, read(folder / ABLATIONS))
    return ScoredCase(
        case=name,
        kind=truth["kind"],
        strength=truth["strength"],
        truth=hidden,
        repeats=f"case_{truth['repeats']:03d}" if truth["repeats"] else "",
        called=called,
        mark=judged(truth["kind"], in_catalogue.values(), called),
        error=verdict.error,
        by_laboratory=_by_laboratory(layout, truth),
        by_diagnosis={effect: _detectability(candidates.get(name)) for effect, name in in_catalogue.items()},
        recovered=tuple(r for name in in_catalogue.values() for r in recovered(name, truth["parameters"], candidates)),
        ablations={name: (call, judged(truth["kind"], in_catalogue.values(), call)) for name, call in others.items()},
        seconds=float(ran["seconds"]),
        processor=float(ran.get("processor", ran["seconds"])),
        test=truth.get("test", EASY.name),
    )


def _by_laboratory(layout: Layout, truth: Mapping[str, Any]) -> dict[str, Detectability]:
    """Of the same case: what was expected of another one under this number counts for nothing."""
    expected = read(layout.expected(truth["case"]))
    if expected is None or expected["digest"] != truth["digest"]:
        return {}
    return {effect: Detectability(one["score"], one["visibility"]) for effect, one in expected["effects"].items()}


def _detectability(candidate: Candidate | None) -> Detectability:
    if candidate is None:
        return Detectability(float("nan"), float("nan"))
    return Detectability(candidate.score, candidate.visibility)


def recovered(
    effect: str, parameters: Mapping[str, Mapping[str, float]], candidates: Mapping[str, Candidate]
) -> tuple[Recovered, ...]:
    """Without those that are truly at their null value: nothing to measure their error by.

    parameters: effect -> name -> true value, in the catalogue's terms
    """
    if effect not in candidates or effect not in parameters:
        return ()
    nulls = CATALOGUE[effect].at_null()
    found = []
    for fitted in candidates[effect].parameters:
        true = parameters[effect][fitted.name]
        if true == nulls[fitted.name]:
            continue
        error = abs(fitted.value - true) / abs(true - nulls[fitted.name])
        inside = fitted.lower <= true <= fitted.upper
        found.append(
            Recovered(effect, fitted.name, true, fitted.value, fitted.lower, fitted.upper, error, inside)
        )  # fmt: skip
    return tuple(found)


def ablations_of(verdict: Verdict, sidecar: Mapping[str, Any] | None) -> dict[str, Called]:
    """From the file ablations.json beside the verdict, or from entries "ablation NAME" of its provenance, each
    {"verdict": ..., "effects": [...], "group": [...]}

    raises: ValueError naming an ablation that is not of that form
    """
    entries: dict[str, Any] = dict(sidecar or {})
    for key, text in verdict.provenance.items():
        if key.startswith(_IN_PROVENANCE):
            entries.setdefault(key.removeprefix(_IN_PROVENANCE), json.loads(text))
    return {name: _called(name, entry) for name, entry in entries.items()}


def _called(name: str, entry: Any) -> Called:
    try:
        return Called(str(entry["verdict"]), tuple(entry.get("effects", ())), tuple(entry.get("group", ())))
    except (KeyError, TypeError, AttributeError):
        raise ValueError(f"ablation '{name}': verdict, effects and group are wanted, not {entry!r}") from None
