"""Stability of one periodic response, from Hill's exponents with checks that say when these cannot be trusted.

What exponents mean with dry friction: the contacts are linearised about a motion that slips and separates every
period, with the memory of their sliders (perturbed_forces.py); sliders at rest stay at rest. A contact that only just
slips, or only just separates, answers differently to the smallest push either way; then the exponents jump with the
time samples, and are not to be trusted. The check is to compute the decisive one again, finer.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.problem.system import NonlinearSystem
from updamp.hbm.stability.condensed_structure import viscous_damping
from updamp.hbm.stability.hill import HillProblem, symmetric_exponents
from updamp.hbm.stability.perturbed_forces import depends_on_growth
from updamp.hbm.stability.strip import FASTEST, Exponent, Strip

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

LOWEST_ORDER = 3
SMALL = 250  # relative rows times coefficients of a system of which all exponents are computed with more harmonics too
CHECKED = 3  # exponents at most, of those nearest to growing, that are computed again otherwise
UNSETTLED = "the exponents of contacts with memory, or with forces that depend on the speed, did not settle"
CONTRADICTED = (
    "the branch runs back here, between two turning points, where a motion grows, and no exponent of the contacts as "
    "they move does: sliders that stand still in this motion take part in what grows"
)


@dataclass(frozen=True)
class StabilityOptions:
    """order: highest harmonic of the perturbation, at least the system's and 3, below which the checks see too little
    tolerance: of an exponent, relative to the angular frequency; slower growth counts as none
    agreement: computed finer, the decisive real part keeps its sign and at least this share of its size
    trace: how far the exponents' sum may be from minus the damping's trace, where there is no memory

    raises: ValueError naming the option that is out of range
    """

    order: int = 0
    tolerance: float = 1e-5
    agreement: float = 0.1
    trace: float = 0.01

    def __post_init__(self) -> None:
        if self.order < 0:
            raise ValueError(f"order = {self.order} must not be negative; 0 for that of the system")
        if not (0 < self.tolerance < 1e-2 and 0 < self.agreement < 1 and 0 < self.trace < 1):
            raise ValueError(
                f"tolerance = {self.tolerance}: between 0 and 0.01; agreement = {self.agreement} and trace = "
                f"{self.trace}: between 0 and 1"
            )


@dataclass(frozen=True, eq=False)
class Stability:
    """stable: no exponent grows; None where no exponent was found that could tell
    exponents: sorted by falling real part [1/s]; all 2 m without memory, with it those of the strip (strip.py); none
    where the determinant tells, or all decay faster than the strip reaches
    trusted: whether the checks were passed, which is about the sign; reason: why not ("" otherwise)
    change: of the largest real part when computed finer [1/s], an estimate of its error
    """

    stable: bool | None
    exponents: Complex
    trusted: bool
    reason: str
    change: float

    @property
    def decisive(self) -> complex:
        """The exponent nearest to growing [1/s]; not a number where none was found."""
        return complex(self.exponents[0]) if len(self.exponents) else complex(np.nan, np.nan)


def stability(
    system: NonlinearSystem,
    x: Floats,
    w: float,
    options: StabilityOptions | None = None,
    against: bool | None = None,
) -> Stability:
    """Stability of one solved point.

    x: (n_relative, n_coefficients) [m]; w [rad/s]
    against: whether the point lies between turning points, if known. If it does, and the Jacobian's determinant says
    the same, or no contact moves on, a real exponent grows, and none is computed; stable it is not called then
    """
    options, mirror = options or StabilityOptions(), system.mirror
    if mirror and system.half and system.other_half and mirror.keeps(x):
        half = mirror.halved(x)
        alike = _of_one(system.half, half, w, options, against)
        return _together(alike, _of_one(system.other_half, half, w, options, None))
    return _of_one(system, x, w, options, against)


def _of_one(system: NonlinearSystem, x: Floats, w: float, options: StabilityOptions, against: bool | None) -> Stability:
    """Of a problem that is not divided further."""
    found = _by_exponents(system, x, w, options, against)
    if against and found.stable and _has_memory(system):
        return replace(found, stable=None, trusted=False, reason=CONTRADICTED)
    return found


def _together(alike: Stability, opposed: Stability) -> Stability:
    """Of a symmetric motion: perturbations that are their own image, and those that are the opposite of it, are free of
    each other.
    """
    both = (alike, opposed)
    if grows := [one for one in both if one.trusted and one.stable is False]:
        return grows[0]
    exponents = np.concatenate([one.exponents for one in both])
    exponents, change = exponents[np.argsort(-exponents.real)], max(one.change for one in both)
    known = all(one.trusted and one.stable for one in both)
    reason = "; ".join(dict.fromkeys(one.reason for one in both if one.reason))
    return Stability(True if known else None, exponents, known, reason, change)


def _by_exponents(
    system: NonlinearSystem, x: Floats, w: float, options: StabilityOptions, against: bool | None
) -> Stability:
    """As `_of_one`, by what tells it quickest"""
    order = max(options.order, system.harmonics.orders[-1], LOWEST_ORDER)
    coarse = HillProblem(system, x, w, order, system.time_samples)
    if not len(coarse.still.rows):
        # shaken-down sliders stand still here, and are taken to in what perturbs it: one that grows moves them
        return _one_grows() if against else _stuck(system, options.tolerance * w)
    if not _has_memory(system):
        fine = HillProblem(system, x, w, order + 2, 2 * system.time_samples)
        exponents, again = symmetric_exponents(coarse), float(symmetric_exponents(fine)[0].real)
        return _judged(exponents, again, w, options, _trace(coarse, exponents, options))
    if coarse.determinant_sign < 0:
        return _odd(coarse, against)
    strip = Strip.of(coarse, options.tolerance)
    found, lost = strip.exponents()
    if not found and not np.isfinite(lost):
        return _all_decay_fast(strip)
    exponents, again = _with_memory(strip, found, lost)
    if np.isnan(again):
        return Stability(None, exponents, False, UNSETTLED, np.inf)
    return _judged(exponents, again, w, options, [])


def _stuck(system: NonlinearSystem, small: float) -> Stability:
    """Nothing slips or separates: the exponents are those of the stuck structure. small: growth that counts as none, as
    that of a motion without damping or of a free one"""
    stuck = system.stuck
    m = len(stuck.omega_squared)
    A = np.block([[np.zeros((m, m)), np.eye(m)], [-np.diag(stuck.omega_squared), -viscous_damping(stuck)]])
    values = np.linalg.eigvals(A).astype(np.complex128)
    values = values[np.argsort(-values.real)]
    return Stability(bool(values[0].real < small), values, True, "", 0.0)


def _has_memory(system: NonlinearSystem) -> bool:
    """Of sliders, or of what depends on the speed"""
    return any(depends_on_growth(group.law) for group in system.groups)


def _one_grows() -> Stability:
    """A real exponent, which is not computed: turning points, or the sign of the Jacobian's determinant, say so."""
    return Stability(False, np.zeros(0, dtype=np.complex128), True, "", np.nan)


def _judged(exponents: Complex, again: float, w: float, options: StabilityOptions, reasons: list[str]) -> Stability:
    """again: the largest real part, computed finer"""
    growth, small = float(exponents[0].real), options.tolerance * w
    reasons = [*_finer_agrees(growth, again, small, options), *reasons]
    return Stability(bool(growth < small), exponents, not reasons, "; ".join(reasons), abs(growth - again))


def _odd(coarse: HillProblem, against: bool | None) -> Stability:
    """The determinant says that an odd number of real exponents grows. If turning points do not say so too, it is
    looked at again with twice the samples.
    """
    none = np.zeros(0, dtype=np.complex128)
    fine = HillProblem(coarse.system, coarse.x, coarse.w, coarse.order, 2 * coarse.time_samples, coarse.structure)
    if against or fine.determinant_sign < 0:
        return _one_grows()
    return Stability(None, none, False, "the sign of the Jacobian's determinant changes with twice the samples", np.inf)


def _all_decay_fast(strip: Strip) -> Stability:
    """No exponent lies in the strip: all decay faster than it reaches, if a finer problem has none there either."""
    none, coarse = np.zeros(0, dtype=np.complex128), strip.problem
    order = coarse.order + 2 * _small(coarse)
    fine = HillProblem(coarse.system, coarse.x, coarse.w, order, 2 * coarse.time_samples)
    found, lost = Strip.of(fine, strip.tolerance).exponents()
    if found or np.isfinite(lost):
        return Stability(None, none, False, UNSETTLED, np.inf)
    return Stability(True, none, True, "", np.nan)


def _small(problem: HillProblem) -> bool:
    return problem.system.free.n_relative * problem.harmonics.n_coefficients <= SMALL


def _with_memory(strip: Strip, found: Sequence[Exponent], lost: float) -> tuple[Complex, float]:
    """Exponents by falling real part, and the decisive one's real part computed finer; not a number where the one or
    the other did not settle, or one that did not may be the decisive one.

    found, lost: as `Strip.exponents` has them
    """
    coarse = strip.problem
    check = _with_more_harmonics if _small(coarse) else _with_more_samples
    decisive, again = check(strip, found) if found else (None, np.nan)
    upper = [*([decisive.s] if decisive else ()), *(one.s for one in found if one is not decisive)]
    small = strip.tolerance * coarse.w
    both = [value for s in upper for value in ([s] if abs(s.imag) < small else [s, s.conjugate()])]
    exponents = np.array(sorted(both, key=lambda s: -s.real), dtype=np.complex128)
    grows = decisive is not None and min(decisive.s.real, again) > small
    return exponents, again if grows or (found and lost < found[0].s.real) else np.nan


def _with_more_harmonics(strip: Strip, found: Sequence[Exponent]) -> tuple[Exponent | None, float]:
    """The decisive exponent with P exactly at its s; and the largest real part with two harmonics more and twice the
    samples.
    """
    coarse = strip.problem
    fine = HillProblem(coarse.system, coarse.x, coarse.w, coarse.order + 2, 2 * coarse.time_samples)
    finer = Strip.of(fine, strip.tolerance)
    decisive, (again, lost) = strip.corrected(found[0], coarse), finer.exponents()
    if not again and not np.isfinite(lost):  # at the strip's end: with more harmonics it lies beyond
        return decisive, -FASTEST * coarse.w
    exact = finer.corrected(again[0], fine) if again else None
    return decisive, exact.s.real if exact and decisive else np.nan


def _with_more_samples(strip: Strip, found: Sequence[Exponent]) -> tuple[Exponent | None, float]:
    """The decisive exponent, and its real part with twice the samples and P exactly at its s."""
    coarse = strip.problem
    checked: list[tuple[float, Exponent]] = []
    fine = HillProblem(coarse.system, coarse.x, coarse.w, coarse.order, 2 * coarse.time_samples, coarse.structure)
    for one in found[:CHECKED]:
        if checked and one.s.real < max(real for real, _ in checked):
            break
        if (again := strip.corrected(one, fine)) is None:
            return None, np.nan
        checked.append((again.s.real, one))
    growth, decisive = max(checked, key=lambda pair: pair[0])
    return decisive, growth


def _finer_agrees(growth: float, again: float, small: float, options: StabilityOptions) -> list[str]:
    """Both below `small` in size are taken as neither growing nor decaying, and agree."""
    largest = max(abs(growth), abs(again))
    if largest < small or (growth * again >= 0 and min(abs(growth), abs(again)) >= options.agreement * largest):
        return []
    return [
        f"the largest real part is {growth:.3g} 1/s, and {again:.3g} with twice the time samples (and two harmonics "
        "more in a small system): a contact only just slips or separates, or there are too few harmonics"
    ]


def _trace(problem: HillProblem, exponents: Complex, options: StabilityOptions) -> list[str]:
    """Liouville: the exponents sum up to minus the trace of the damping, if the right ones were chosen."""
    wanted = -float(np.trace(problem.structure.damping))
    found = float(exponents.sum().real)
    if abs(found - wanted) <= options.trace * abs(wanted) + options.tolerance * problem.w:
        return []
    return [f"the exponents sum up to {found:.4g} 1/s instead of {wanted:.4g}: too few harmonics to tell them apart"]
