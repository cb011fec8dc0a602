"""When a sentence of `updamp compare` counts as right, by rule.

The first sentence names a quantity (resonance, peak height, left tip over right), a mode or all of them, a level or all
of them, and whether the model reads high or low. It is right if both hold at every test that it names:

1. The curves show it: a plain reading of the raw curves (largest value; middle between the places at 95 % of it), as
   mean over repeats, has the same sign and at least half the size said.
2. The effect does it: the laboratory's own peaks, with the effect and without, differ by more than what is visible in
   the opposite direction (a model without the effect reads high where the effect lowers).

"yes" if that holds of the laboratory's change itself; "yes, calibrated" if only of what is left of it once
the mean is taken off that calibration takes up: of the resonances' changes the mean of the mode (Young's modulus and
contact stiffness), of the heights' the mean of all tests (loss factor). With nothing hidden "no misfit" is right.

Apart from that it is told whether the first sentence is of the quantity that the effect changes most, before or after
those means are taken off: as sum of squares over tests of what amplitudes change by at most (of a left over right that
rises by 2 % each tip by 1 %; a shift by a half-width changes amplitudes by 0.385 of the peak).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from updamp.benchmarks.hidden_effects.cases import Case
from updamp.benchmarks.hidden_effects.layout import read, write_whole
from updamp.benchmarks.virtual_rig.bench import Bench, bench_of
from updamp.benchmarks.virtual_rig.bodies import LABORATORY, bodies_of
from updamp.benchmarks.virtual_rig.laboratory import with_hidden
from updamp.benchmarks.virtual_rig.measurement import RIG
from updamp.benchmarks.virtual_rig.plan import SIX_CURVES
from updamp.benchmarks.virtual_rig.visibility import USUAL, peak
from updamp.comparison.comparison import Comparison, CurvePair, Finding
from updamp.model.rig_files import load_rig
from updamp.workflow.code_version import code_version

Floats = NDArray[np.float64]
Changes = Mapping[str, Mapping[str, float]]

FREQUENCY, HEIGHT, SIDES = "resonance", "peak", "left over right"
QUANTITIES = {"frequency": FREQUENCY, "amplitude": HEIGHT, "sensor": SIDES}
# Changes of the logarithm that count as visible.
VISIBLE = {FREQUENCY: 1e-4, HEIGHT: 0.01, SIDES: 0.01}
# Change of the logarithm by which amplitudes change by their whole: half-widths of this laboratory are 0.2 to 0.3 %.
WHOLE = {FREQUENCY: 0.0025 / 0.385, HEIGHT: 1.0, SIDES: 2.0}


@dataclass(frozen=True)
class Judged:
    """does: what the effect does, in words; plain: raw reading at the tests named; mark: "yes", "yes, calibrated",
    "no" or "missed"; why: where it is not a plain yes; main: whether it is of the quantity that changes most"""

    does: str
    plain: dict[str, float]
    mark: str
    why: str = ""
    main: bool = False


def judged(comparison: Comparison, changes: Changes) -> Judged:
    """changes: test -> quantity -> change of the logarithm that the effect makes; empty where nothing is hidden"""
    if not changes:
        silent = comparison.adequate
        return Judged("nothing", {}, "yes" if silent else "no", "" if silent else "something is said")
    does = in_words(changes)
    if not comparison.findings:
        return Judged(does, {}, "missed")
    first = comparison.findings[0]
    quantity, tests = QUANTITIES.get(first.quantity), _tests(first, comparison)
    if quantity is None or not _reads_peaks(first):
        return Judged(does, {}, "no", "nothing is said of resonance, peak or sides")
    plain = {test: _plain(comparison, test)[quantity] for test in tests}
    stated = float(np.log1p(first.relative))
    if not all(value * stated > 0 and abs(value) >= abs(stated) / 2 for value in plain.values()):
        return Judged(does, plain, "no", "the curves do not show it")
    for mark, removed in (("yes", _nothing), ("yes, calibrated", _calibrated)):
        left = {test: changes[test][quantity] - removed(changes, test, quantity) for test in tests}
        if all(-value * stated > 0 and abs(value) >= VISIBLE[quantity] for value in left.values()):
            return Judged(does, plain, mark, main=quantity in _main(changes))
    return Judged(does, plain, "no", "the effect does not do that")


def _main(changes: Changes) -> set[str]:
    """The quantity that changes most, as it is and after calibration."""
    found = set()
    for removed in (_nothing, _calibrated):
        sizes = {
            q: sum(((values[q] - removed(changes, test, q)) / WHOLE[q]) ** 2 for test, values in changes.items())
            for q in WHOLE
        }
        found.add(max(sizes, key=lambda q: sizes[q]))
    return found


def _reads_peaks(first: Finding) -> bool:
    return "differ in shape" not in first.text


def _nothing(_changes: Changes, _test: str, _quantity: str) -> float:
    return 0.0


def _calibrated(changes: Changes, test: str, quantity: str) -> float:
    if quantity == SIDES:
        return 0.0
    alike = [t for t in changes if quantity == HEIGHT or t.split()[0] == test.split()[0]]
    return float(np.mean([changes[t][quantity] for t in alike]))


def _tests(first: Finding, comparison: Comparison) -> list[str]:
    """Names of the runs that a sentence is about; of levels that differ, the one that is worst."""
    runs = {c.run: c for c in comparison.curves}
    return [
        name
        for name, c in runs.items()
        if first.mode in ("", c.mode) and (first.level is None or abs(c.level / first.level - 1) < 0.02)
    ]


def _plain(comparison: Comparison, test: str) -> dict[str, float]:
    """Logarithms of model over measured, by the raw curves of the left and the right tip."""
    pairs = {c.channel: c for c in comparison.curves if c.run == test}
    found = {}
    for side in ("tip_left", "tip_right"):
        pair = pairs[side]
        measured = np.array([_top(m.frequency, np.abs(m.receptance), _everywhere) for m in pair.measured])
        inside = _inside(pair)
        visited = pair.after.visited
        model = _top(pair.after.frequency[visited], np.abs(pair.after.receptance[visited]), inside)
        found[side] = np.log(model) - np.log(measured).mean(axis=0)
    (f_left, left), (f_right, right) = found["tip_left"], found["tip_right"]
    return {FREQUENCY: float(f_left + f_right) / 2, HEIGHT: float(left + right) / 2, SIDES: float(left - right)}


def _everywhere(frequency: Floats) -> NDArray[np.bool_]:
    return np.ones(len(frequency), dtype=bool)


def _inside(pair: CurvePair) -> Callable[[Floats], NDArray[np.bool_]]:
    low = min(m.frequency.min() for m in pair.measured)
    high = max(m.frequency.max() for m in pair.measured)
    return lambda f: (f >= low) & (f <= high)


def _top(frequency: Floats, size: Floats, allowed: Callable[[Floats], NDArray[np.bool_]]) -> tuple[float, float]:
    """Middle between the places at 95 % of the largest value, and that value; another mode's flank is no top."""
    order = np.argsort(frequency)
    f, a = frequency[order], size[order]
    is_top = np.zeros(len(f), dtype=bool)
    is_top[1:-1] = (a[1:-1] >= a[:-2]) & (a[1:-1] >= a[2:])
    tops = is_top & allowed(f)
    i = int(np.argmax(np.where(tops, a, 0.0))) if tops.any() else int(np.argmax(np.where(allowed(f), a, 0.0)))
    ends = []
    for side in (-1, 1):
        k = i
        while 0 <= k + side < len(f) and a[k] > 0.95 * a[i]:
            k += side
        near, far = (k - side, k) if a[k] <= 0.95 * a[i] else (k, k)
        share = (a[near] - 0.95 * a[i]) / (a[near] - a[far]) if far != near and a[near] != a[far] else 0.0
        ends.append(f[near] + share * (f[far] - f[near]))
    return float(np.mean(ends)), float(a[i])


def laboratory_changes(case: Case, folder: Path) -> dict[str, dict[str, float]]:
    """What a case's effects do to the laboratory's peaks, without noise or scatter: kept by their names, and made anew
    when the laboratory's source has changed."""
    if not case.hidden:
        return {}
    path = folder / ("+".join(f"{one.name}_{one.strength}" for one in case.hidden) + ".json")
    known, code = read(path), code_version(*LABORATORY)
    if known is not None and known.get("code") == code:
        return {test: dict(values) for test, values in known["changes"].items()}
    rig, plain = load_rig(RIG), _peaks_without(case.laboratory)
    changed = _peaks(with_hidden(_nominal(case.laboratory), list(case.hidden), rig))
    found = {}
    for test, (f0, right0, left0) in plain.items():
        f, right, left = changed[test]
        found[test] = {
            FREQUENCY: float(np.log(f / f0)),
            HEIGHT: float(np.log(right / right0 * left / left0)) / 2,
            SIDES: float(np.log(left / right / (left0 / right0))),
        }
    write_whole(path, {"code": code, "changes": found})
    return found


@cache
def _nominal(preset: str) -> Bench:
    return bench_of(load_rig(RIG), bodies_of(load_rig(RIG), preset))


@cache
def _peaks_without(preset: str) -> dict[str, tuple[float, float, float]]:
    return _peaks(_nominal(preset))


def _peaks(bench: Bench) -> dict[str, tuple[float, float, float]]:
    """Test -> frequency of the right tip's peak [Hz], heights of the right and the left tip's [m/N]"""
    return {run.name: peak(bench, run, USUAL) for run in SIX_CURVES}


def in_words(changes: Changes) -> str:
    """Changes of each mode, from the lowest level to the highest, of the quantities that change visibly."""
    parts = []
    for mode in dict.fromkeys(test.split()[0] for test in changes):
        of_mode = [values for test, values in changes.items() if test.split()[0] == mode]
        for quantity in (FREQUENCY, HEIGHT, SIDES):
            values = np.expm1([v[quantity] for v in of_mode]) * 100
            if np.max(np.abs(values)) >= 100 * VISIBLE[quantity]:
                digits = 2 if quantity == FREQUENCY else 0
                parts.append(f"{mode} {quantity} " + ", ".join(f"{v:+.{digits}f}" for v in values) + " %")
    return "; ".join(parts) or "hardly anything at the peaks"
