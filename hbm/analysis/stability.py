"""Stability of a periodic response: from turning points, and from Hill's exponents with checks that say when not.

Turning points are exact for the equations solved: there the Jacobian is singular and a real exponent passes zero.
Between two of them, on the part that runs against the sweep, the response is unstable. That it is stable elsewhere
takes exponents, since pairs of them can pass the imaginary axis with the frequency running on.

What exponents mean with dry friction: the contacts are linearised about a motion that slips and separates every
period, with the memory of their sliders (hbm/analysis/perturbed_forces.py); sliders at rest stay at rest. A contact
that only just slips, or only just separates, answers differently to the smallest push either way; then the exponents
jump with the time samples, and are not to be trusted. The check is to compute them again, finer.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.analysis.hill import HillProblem
from updamp.hbm.analysis.perturbed_forces import has_memory
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.continuation.sweeps import turning_points
from updamp.hbm.problem.system import NonlinearSystem

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

LOWEST_ORDER = 3
UNSETTLED = "Newton's method did not settle the exponents with the sliders' memory"


@dataclass(frozen=True)
class StabilityOptions:
    """order: highest harmonic of the perturbation, at least the system's and 3, below which the checks see too little
    followed: exponents with memory that Newton's method settles, of those nearest to growing without it; modes above
    the highest harmonic are left out, since the harmonics kept cannot tell how contacts answer them
    tolerance: of an exponent, relative to the angular frequency
    agreement: computed finer, the decisive real part keeps its sign and at least this share of its size
    trace: how far the exponents' sum may be from minus the damping's trace, where there is no memory

    raises: ValueError naming the option that is out of range
    """

    order: int = 0
    followed: int = 6
    tolerance: float = 1e-7
    agreement: float = 0.1
    trace: float = 0.01

    def __post_init__(self) -> None:
        if self.order < 0 or self.followed < 1:
            raise ValueError(f"order = {self.order} must not be negative and followed = {self.followed} at least 1")
        if not (0 < self.tolerance < 1e-2 and 0 < self.agreement < 1 and 0 < self.trace < 1):
            raise ValueError(
                f"tolerance = {self.tolerance}: between 0 and 0.01; agreement = {self.agreement} and trace = "
                f"{self.trace}: between 0 and 1"
            )


@dataclass(frozen=True, eq=False)
class Stability:
    """stable: no exponent grows; None where no exponent was found that could tell
    exponents: sorted by falling real part [1/s]; all 2 m of them without memory, with it the followed ones that settled
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


def between_turning_points(frequency: Floats) -> NDArray[np.bool_]:
    """(n,) True on the parts of a branch that run against its beginning: unstable, whatever the exponents say.

    A branch is entered on a part that a sweep can follow, as in hbm/continuation/sweeps.py. Points at which it turns
    count as past.
    """
    parity = np.zeros(len(frequency), dtype=np.int64)
    for place in turning_points(frequency):
        parity[place + 1 :] += 1
    against: NDArray[np.bool_] = parity % 2 == 1
    return against


def stability(
    system: NonlinearSystem,
    x: Floats,
    w: float,
    options: StabilityOptions | None = None,
    against: bool | None = None,
) -> Stability:
    """Stability of one solved point.

    x: (n_relative, n_coefficients) [m]; w [rad/s]
    against: whether the point lies between turning points, if known: the number of real growing exponents is then
    odd, and even otherwise
    """
    options = options or StabilityOptions()
    order = max(options.order, system.harmonics.orders[-1], LOWEST_ORDER)
    memory = any(has_memory(group.law) for group in system.groups)
    coarse = HillProblem(system, x, w, order, system.time_samples)
    fine = HillProblem(system, x, w, order + 2, 2 * system.time_samples)
    (exponents, settled), (finer, finer_settled) = (_exponents(p, memory, options) for p in (coarse, fine))
    if not len(exponents) or not len(finer):
        # between turning points it is unstable whatever the exponents; elsewhere they alone tell
        return Stability(False if against else None, exponents, False, UNSETTLED, np.inf)
    growth, again, small = float(exponents[0].real), float(finer[0].real), options.tolerance * w
    reasons = [] if settled and finer_settled else [UNSETTLED]
    if growth * again < 0 or min(abs(growth), abs(again)) < options.agreement * max(abs(growth), abs(again)):
        reasons.append(
            f"the largest real part is {growth:.3g} 1/s, and {again:.3g} with two harmonics more and twice the time "
            "samples: a contact only just slips or separates, or there are too few harmonics"
        )
    if not memory:
        reasons += _trace(coarse, exponents, options)
    reasons += _parity(exponents, against, small)
    return Stability(growth < small, exponents, not reasons, "; ".join(reasons), abs(growth - again))


def stability_of_curve(
    system: NonlinearSystem,
    curve: ResponseCurve,
    places: Sequence[int] | None = None,
    options: StabilityOptions | None = None,
) -> Iterator[Stability]:
    """Of the points at `places` on the curve (default: all), with its turning points as a further check."""
    against = between_turning_points(curve.frequency)
    at_turn = turning_points(curve.frequency)  # on which side of the turn the nearest point lies is not known
    for i in range(len(curve)) if places is None else places:
        known = None if i in at_turn else bool(against[i])
        yield stability(system, curve.displacement[i], 2 * np.pi * curve.frequency[i], options, known)


def _exponents(problem: HillProblem, memory: bool, options: StabilityOptions) -> tuple[Complex, bool]:
    """Exponents by falling real part, and whether all that were followed have settled."""
    values, vectors = problem.floquet(*problem.eigen())
    if not memory:
        return values, True
    small = options.tolerance * problem.w
    within = (values.imag >= -small) & (values.imag <= problem.order * problem.w)
    upper = np.flatnonzero(within)[: options.followed]
    followed = [problem.refine(complex(values[i]), vectors[:, i], options.tolerance) for i in upper]
    found: list[complex] = []
    for s, _, settled in followed:
        if settled and all(abs(s - other) > 10 * small for other in found):
            found += [s] if abs(s.imag) < small else [s, s.conjugate()]
    exponents = np.array(sorted(found, key=lambda s: -s.real), dtype=np.complex128)
    return exponents, all(settled for *_, settled in followed)


def _trace(problem: HillProblem, exponents: Complex, options: StabilityOptions) -> list[str]:
    """Liouville: the exponents sum up to minus the trace of the damping, if the right ones were chosen."""
    wanted = -float(np.trace(problem.damping))
    found = float(exponents.sum().real)
    if abs(found - wanted) <= options.trace * abs(wanted) + options.tolerance * problem.w:
        return []
    return [f"the exponents sum up to {found:.4g} 1/s instead of {wanted:.4g}: too few harmonics to tell them apart"]


def _parity(exponents: Complex, against: bool | None, small: float) -> list[str]:
    growing = int(np.sum((np.abs(exponents.imag) < small) & (exponents.real > small)))
    if against is None or growing % 2 == against:
        return []
    side = "between" if against else "outside"
    return [
        f"{growing} real exponents grow, {side} turning points where their number is {'odd' if against else 'even'}"
    ]
