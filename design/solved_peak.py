"""The response at one resonance, whichever way it was found."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.design.tracked_modes import TrackedMode, UnknownResponseError
from updamp.effects.rig_model import RigModel
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.resonance.conditions import MaximumResonance
from updamp.hbm.resonance.resonance_curve import ResonanceCurve, ResonanceRequest, whole_resonance
from updamp.hbm.resonance.resonance_steps import ResonanceOptions

RESONANCE, RESONANCE_ONLY, CURVE = "resonance", "resonance_only", "curve"


@dataclass(frozen=True)
class PeakRequest:
    """Largest first harmonic of one point in one mode. force: [N]; by: "resonance" (followed in the force, the whole
    curve where that stops), "resonance_only" or "curve" """

    mode: str
    force: float
    point: str
    by: str = RESONANCE


@dataclass(frozen=True, eq=False)
class SolvedPeak:
    """frequency: [Hz]; receptance: [m/N]; displacement: (n_relative, n_coefficients) at the contacts [m]
    work_in, friction_loss: a cycle [J]; by: "resonance" or "curve", whichever gave it
    """

    frequency: float
    receptance: float
    displacement: NDArray[np.float64]
    work_in: float
    friction_loss: float
    by: str


@dataclass(frozen=True, eq=False)
class FollowedPeaks:
    """A resonance followed in the force: where it met the forces that were asked for.

    met: at these forces alone, with the reason why the following ones were not reached
    given_up: whether that is because it took too many points; the whole curve then takes many too
    """

    met: ResonanceCurve
    given_up: bool

    def at(self, force: float) -> SolvedPeak | None:
        """[N]; None where it was not reached"""
        at = np.flatnonzero(np.isclose(self.met.force, force, rtol=1e-9))
        return _of_resonance(self.met, int(at[0])) if len(at) else None


def followed_peaks(model: RigModel, request: ResonanceRequest) -> FollowedPeaks:
    """What stops on the way is said in `met.stopped`. raises: ValueError where the window has no mode"""
    whole, options = whole_resonance(model.system, request), request.options or ResonanceOptions()
    given_up = not whole.complete and len(whole) >= options.max_points
    if given_up:
        far = f"it took more than {options.max_points} points, the last at {whole.force[-1]:.4g} N"
        whole = replace(whole, stopped=f"the resonance was given up: {far}")
    return FollowedPeaks(whole.at_forces() if len(whole) else whole, given_up)


def resonance_request(
    model: RigModel, mode: str, point: str, stuck: TrackedMode, forces: Sequence[float], most_points: int | None
) -> ResonanceRequest:
    """Of the peaks at the forces [N, rising], from a hundredth of the first on, where the structure is all but linear.

    stuck: the mode where it lies now; another one in its window is not taken for it
    most_points: of the resonance; None: as many as are usual
    """
    options = ResonanceOptions() if most_points is None else ResonanceOptions(max_points=most_points)
    return ResonanceRequest(
        mode, model.excitation, point, stuck.window, (forces[0] / 100, *forces), MaximumResonance(), options,
        mode_frequency=stuck.frequency,
    )  # fmt: skip


def _of_resonance(met: ResonanceCurve, i: int) -> SolvedPeak:
    return SolvedPeak(
        float(met.frequency[i]), float(abs(met.receptance[i])), met.displacement[i],
        float(met.work_in[i]), float(met.friction_loss[i]), RESONANCE,
    )  # fmt: skip


def peak_of_curve(curve: ResponseCurve, point: str) -> SolvedPeak:
    """raises: UnknownResponseError where the curve is not complete: what was not followed may hold a higher peak"""
    require_complete(curve)
    frequency, receptance = curve.peak(point)
    i = int(np.abs(curve.receptance(point)).argmax())
    return SolvedPeak(
        frequency, receptance, curve.displacement[i], float(curve.work_in[i]), float(curve.friction_loss[i]), CURVE
    )


def require_complete(curve: ResponseCurve) -> None:
    """raises: UnknownResponseError with the curve's own reason"""
    if not curve.complete:
        reason = curve.stopped or "it has no point"
        raise UnknownResponseError(f"the curve {curve.mode} at {curve.force:g} N is not complete: {reason}")
