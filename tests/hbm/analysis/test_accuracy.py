"""What finer settings change against converged references, and the search for the cheapest setting."""

import numpy as np
import pytest
from support.peers import blades_and_damper_system, one_degree_of_freedom, solved

from updamp.hbm.analysis.accuracy import CheckedPoints, Deviation
from updamp.hbm.analysis.adaptive import AdaptiveStatus, adaptive, with_orders
from updamp.hbm.analysis.settings import (
    Refinement,
    Setting,
    more_harmonics,
    one_more_cycle,
    setting_of,
    twice_the_samples,
    with_setting,
)
from updamp.hbm.contact.coulomb_circle import CoulombCircle
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.continuation.continuation import ContinuationOptions
from updamp.hbm.continuation.curve import CurveRequest, trace
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.system import Excitation, NonlinearSystem

FINE = ContinuationOptions(largest_step=0.1)


def friction_request(system: NonlinearSystem, force: float = 40.0) -> CurveRequest:
    excitation = Excitation(system.free.row("excitation"), force)
    return CurveRequest("1", excitation, (230.6, 232.8), ("tip",), options=ContinuationOptions(frequency_scale=4.0))


def duffing(orders: tuple[int, ...] = (0, 1)) -> NonlinearSystem:
    d = solved("a_duffing_1dof")["definition"]
    group = ElementGroup(CubicSpring(), CubicParameters(np.array([d["g"]])), np.array([[0]]))
    return one_degree_of_freedom(d["c"], group, orders, 64)


def duffing_request(system: NonlinearSystem, share: float = 1.0, options: ContinuationOptions = FINE) -> CurveRequest:
    """share: of the force of the solved problem"""
    force = share * solved("a_duffing_1dof")["definition"]["P"]
    window = (0.5 / 2 / np.pi, 2.0 / 2 / np.pi)
    return CurveRequest("1", Excitation(system.free.row("mass"), force), window, ("mass",), options=options)


def last(system: NonlinearSystem, request: CurveRequest):
    *_, curve = trace(system, request)
    assert curve.complete
    return curve


def changes(
    system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, *refinements: Refinement
) -> list[Deviation]:
    """At the peak alone."""
    peak = CheckedPoints.at(system, request, curve, request.peaks_at[0], np.zeros(0, dtype=np.int64))
    return [peak.deviation(refine) for refine in refinements]


def at_phase(curve, point: str, phase: float) -> float:
    """Frequency [Hz] on the first passage through the phase."""
    lag = -np.unwrap(np.angle(curve.receptance(point)))
    return float(np.interp(-phase, lag, curve.frequency))


def test_peak_against_a_converged_reference_with_separation():
    """Harmonics 0-3 and 128 samples at 40 N, against 0-9 and 256 samples (more change the peak by less than 0.01 %)."""
    system = blades_and_damper_system(JenkinsBox(2))
    request = friction_request(system)
    curve = last(system, request)
    converged = last(with_setting(system, Setting(tuple(range(10)), 256, 2)), request)
    harmonics, samples, cycles = changes(system, request, curve, more_harmonics, twice_the_samples, one_more_cycle)
    error = 100 * (converged.peak("tip")[1] / curve.peak("tip")[1] - 1)
    assert error < -2
    assert harmonics.peak_percent == pytest.approx(error, rel=0.15)
    top = np.argmax(np.abs(curve.receptance("tip")))
    phase = float(np.angle(curve.receptance("tip")[top]))
    shift = at_phase(converged, "tip", phase) - curve.frequency[top]
    # 0.01 Hz up or down from one harmonic to the next is what is left of the convergence of this resonance
    assert harmonics.peak_hertz == pytest.approx(shift, abs=0.015)
    assert abs(samples.peak_percent) < 0.01
    assert abs(cycles.peak_percent) < 1e-6, "the box law settles in two cycles"
    assert harmonics.unsolved == samples.unsolved == cycles.unsolved == ()


def test_one_more_cycle_of_a_law_that_settles_slowly():
    """The circle law: from two cycles to three most of what six would change."""
    system = blades_and_damper_system(CoulombCircle(2), (0, 1), 64)
    request = friction_request(system)
    curve = last(system, request)
    settled = with_setting(system, Setting((0, 1), 64, 6))
    converged, next_one = changes(system, request, curve, lambda _: setting_of(settled), one_more_cycle)
    assert abs(converged.peak_percent) > 1e-4
    assert 0.5 < next_one.peak_percent / converged.peak_percent < 1.0


def test_peak_that_overhangs_against_a_converged_reference():
    system = duffing((0, 1))
    request = duffing_request(system)
    curve = last(system, request)
    (found,) = changes(system, request, curve, more_harmonics)
    converged = last(with_setting(system, Setting(tuple(range(12)), 256)), request)
    error = 100 * (converged.peak("mass")[1] / curve.peak("mass")[1] - 1)
    assert found.peak_percent == pytest.approx(error, rel=0.1)
    top = np.argmax(np.abs(curve.receptance("mass")))
    phase = float(np.angle(curve.receptance("mass")[top]))
    shift = at_phase(converged, "mass", phase) - curve.frequency[top]
    assert found.peak_hertz == pytest.approx(shift, rel=0.1)


def test_a_converged_curve_is_hardly_changed():
    system = duffing(tuple(range(8)))
    request = duffing_request(system)
    (found,) = changes(system, request, last(system, request), more_harmonics)
    assert abs(found.peak_percent) < 1e-3
    assert abs(found.peak_hertz) < 1e-5


def traced(system: NonlinearSystem, request: CurveRequest):
    """Harmonics -> curve, with 128 samples."""
    return lambda orders: list(trace(with_setting(system, with_orders(Setting((0, 1), 128), orders)), request))[-1]


def test_stronger_force_takes_more_harmonics_and_the_tolerance_is_met():
    system = duffing()
    weak, strong = (
        adaptive(traced(system, duffing_request(system, share)), (0, 1), "mass", 1e-4) for share in (0.1, 1.0)
    )
    assert weak.status is strong.status is AdaptiveStatus.MET
    assert len(weak.curve.orders) < len(strong.curve.orders)
    converged = last(with_setting(system, Setting(tuple(range(14)), 256)), duffing_request(system)).peak("mass")[1]
    assert strong.curve.peak("mass")[1] == pytest.approx(converged, rel=1e-4)
    coarser = traced(system, duffing_request(system))(strong.tried[0]).peak("mass")[1]
    assert coarser != pytest.approx(converged, rel=1e-4), "the first harmonics would not have done"


def test_the_highest_harmonics_are_said_to_be_reached():
    system = duffing()
    found = adaptive(traced(system, duffing_request(system)), (0, 1), "mass", 1e-9, highest=3)
    assert found.status is AdaptiveStatus.HIGHEST_REACHED
    assert found.tried == ((0, 1), (0, 1, 2, 3))
    assert found.curve.orders == (0, 1, 2, 3)


def test_curves_that_stop_or_are_interrupted():
    system = duffing()
    whole = traced(system, duffing_request(system))
    short = traced(system, duffing_request(system, options=ContinuationOptions(max_points=3)))
    assert adaptive(short, (0, 1), "mass", 0.01).status is AdaptiveStatus.NOT_TRACED
    lost = adaptive(lambda orders: whole(orders) if orders == (0, 1) else short(orders), (0, 1), "mass", 1e-9)
    assert lost.status is AdaptiveStatus.FINER_NOT_TRACED
    assert lost.curve.orders == (0, 1)
    assert lost.curve.complete
    stopped = adaptive(lambda orders: whole(orders) if orders == (0, 1) else None, (0, 1), "mass", 1e-9)
    assert stopped.curve is None
    assert stopped.status is None


def test_refinements():
    setting = Setting((0, 1, 2, 3), 16, 2)
    assert more_harmonics(setting) == Setting(tuple(range(8)), 28, 2)
    assert more_harmonics(Setting((1, 3), 64)).orders == (1, 3, 5, 7)
    assert one_more_cycle(twice_the_samples(setting)) == Setting((0, 1, 2, 3), 32, 3)
    assert one_more_cycle(Setting((0, 1), 64)).cycles is None
    system = with_setting(blades_and_damper_system(CoulombCircle(3)), setting)
    assert setting_of(system) == setting
    assert system.groups[0].law == CoulombCircle(2)


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: adaptive(lambda _: None, (0, 1), "mass", 0.0), "tolerance"),
        (lambda: Setting((0, 1, 2, 3), 6), "time_samples"),
        (lambda: Setting((0, 1), 64, 0), "cycles"),
    ],
)
def test_bad_values_are_refused_by_name(make, name):
    with pytest.raises(ValueError, match=name):
        make()
