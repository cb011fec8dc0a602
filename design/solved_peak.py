"""The response at one resonance, whichever way it was found."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.design.tracked_modes import TrackedMode, UnknownResponseError
from updamp.effects.rig_model import RigModel
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.resonance.conditions import MaximumResonance
from updamp.hbm.resonance.resonance_curve import ResonanceCurve, ResonanceRequest, whole_resonance

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


def followed_peaks(
    model: RigModel, mode: str, point: str, stuck: TrackedMode, forces: Sequence[float]
) -> tuple[dict[float, SolvedPeak], str]:
    """Peaks at the forces [N, rising] that the resonance reaches, and why it stopped before the last ("" where not).

    stuck: the mode where it lies now; another one in its window is not taken for it
    Following begins at a hundredth of the first force, where the structure is all but linear.
    """
    request = ResonanceRequest(
        mode, model.excitation, point, stuck.window, (forces[0] / 100, *forces), MaximumResonance(),
        mode_frequency=stuck.frequency,
    )  # fmt: skip
    try:
        whole = whole_resonance(model.system, request)
    except ValueError as error:  # no stuck mode in the window
        return {}, str(error)
    if not len(whole):
        return {}, whole.stopped
    met = whole.at_forces()
    peaks = {}
    for force in forces:
        at = np.flatnonzero(np.isclose(met.force, force, rtol=1e-9))
        if len(at):
            peaks[force] = _of_resonance(met, int(at[0]))
    return peaks, whole.stopped


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
