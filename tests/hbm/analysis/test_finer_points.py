"""What samples and cycles change at the peak and on the flanks, without anything raised."""

from dataclasses import replace

import numpy as np
import pytest
from support.peers import blades_and_damper_system

from updamp.hbm.analysis.accuracy import CheckedPoints
from updamp.hbm.analysis.finer_points import point_errors
from updamp.hbm.analysis.settings import one_more_cycle, twice_the_samples
from updamp.hbm.contact.coulomb_circle import CoulombCircle
from updamp.hbm.continuation.continuation import ContinuationOptions
from updamp.hbm.continuation.curve import CurveRequest, trace
from updamp.hbm.problem.system import Excitation


@pytest.fixture(scope="module")
def traced():
    """A law that settles slowly, so that one more cycle changes something."""
    system = blades_and_damper_system(CoulombCircle(2))
    excitation = Excitation(system.free.row("excitation"), 40.0)
    options = ContinuationOptions(frequency_scale=4.0)
    request = CurveRequest("1", excitation, (230.6, 232.8), ("tip",), options=options)
    *_, curve = trace(system, request)
    return system, request, curve


@pytest.mark.long
def test_at_the_peak_they_are_those_of_the_points_around_it(traced):
    system, request, curve = traced
    found = point_errors(system, request, curve, "tip")
    peak = CheckedPoints.at(system, request, curve, "tip", np.zeros(0, dtype=np.int64))
    samples, cycles = peak.deviation(twice_the_samples), peak.deviation(one_more_cycle)
    assert found.reason == ""
    assert found.samples[:2] == pytest.approx((samples.peak_percent, samples.peak_hertz), abs=1e-9)
    assert found.cycles[:2] == pytest.approx((cycles.peak_percent, cycles.peak_hertz), abs=1e-9)
    assert found.cycles[0] != 0
    assert found.samples[2] > 0, "flanks have changes of their own"


def test_what_fails_is_not_known_and_says_why(traced):
    system, request, curve = traced
    for broken, reason in (
        (replace(curve, frequency=curve.frequency[:1], response=curve.response[:1]), "fewer than two points"),
        (replace(curve, displacement=np.full_like(curve.displacement, np.nan)), ""),
    ):
        found = point_errors(system, request, broken, "tip")
        assert np.isnan(found.samples).all()
        assert np.isnan(found.cycles).all()
        assert found.reason
        assert reason in found.reason
