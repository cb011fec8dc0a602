"""Curves are the same for whoever traces them (small mesh): upwards and downwards, after a change of round-off, with
one thread and with two. Of a rig whose contacts open early, which is harder than the reference rig; of that, its
busiest curve.
"""

import json
import os
import subprocess
import sys
from dataclasses import asdict, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from updamp.benchmarks.reproducibility import CURVES, RIG, Reading, read, small_model, with_round_off
from updamp.benchmarks.stress import StressCase, system_of
from updamp.fem.static_contact.static_contact import static_contact
from updamp.hbm.continuation.curve import whole_curve
from updamp.hbm.resonance.conditions import MaximumResonance
from updamp.hbm.resonance.resonance_curve import ResonanceRequest, trace_resonance
from updamp.model.build import rig_model
from updamp.model.rig_files import load_rig

OPENS_EARLY = Path(__file__).parents[1] / "data" / "early_opening.toml"
PEAK, FREQUENCY = 1e-3, 0.05  # relative; [Hz]
LONGEST = ("IP", 17.0)  # hundreds of points: not traced once more with another round-off

# numpy is loaded before the benchmark sets its one thread.
TWO_THREADS = """
import json, numpy, sys
from dataclasses import asdict
from updamp.benchmarks.reproducibility import read, small_model
from updamp.model.rig_files import load_rig
rig = load_rig(sys.argv[1])
print(json.dumps(asdict(read("two threads", rig, small_model(rig), "IP", 9.6, True))))
"""


@pytest.fixture(scope="module")
def rig():
    return load_rig(OPENS_EARLY)


@pytest.fixture(scope="module")
def reduced(rig):
    return small_model(rig)


@pytest.fixture(scope="module")
def upwards(rig, reduced):
    """Reading of a curve, traced once for all tests."""
    return cache(lambda mode, force: read("upwards", rig, reduced, mode, force, True))


@pytest.mark.parametrize(
    ("mode", "force"),
    [pytest.param(*curve, marks=() if curve == ("OOP", 17.0) else pytest.mark.long) for curve in CURVES],
)
def test_direction_and_round_off_change_nothing_that_is_read_from_a_curve(rig, reduced, upwards, mode, force):
    first = upwards(mode, force)
    assert first.complete
    assert_same(read("downwards", rig, reduced, mode, force, False), first)
    if (mode, force) != LONGEST:
        assert_same(read("round-off", rig, with_round_off(reduced, 1), mode, force, True), first)


@pytest.mark.long
def test_neither_do_they_at_the_reference_rigs_busiest_curve():
    rig = load_rig(RIG)
    reduced = small_model(rig)
    first = read("upwards", rig, reduced, *LONGEST, True)
    assert first.complete
    assert_same(read("downwards", rig, reduced, *LONGEST, False), first)


# Both of the stress grid. The first was read 6 % too high where the top was looked for beyond the points beside it.
# The second was 2 % higher downwards, where a long step had ended on another branch.
AT_A_KINK = StressCase("IP", force_N=9.025, mu=0.3697, kt_N_per_mm3=1308.0, kn_N_per_mm3=4.31e6, pull_N=425.8)
BESIDE_ANOTHER = StressCase("IP", force_N=28.37, mu=0.6177, kt_N_per_mm3=5.259e4, kn_N_per_mm3=1.007e4, pull_N=2386.0)


@pytest.mark.long
@pytest.mark.parametrize("case", [AT_A_KINK, BESIDE_ANOTHER], ids=["at a kink", "beside another branch"])
def test_a_false_peak_is_mended(reduced, case):
    system, request = system_of(case, reduced)
    curves = [whole_curve(system, replace(request, upwards=upwards)) for upwards in (True, False)]
    assert all(curve.complete for curve in curves)
    (frequency, peak), (other_frequency, other_peak) = (curve.peak(request.points[0]) for curve in curves)
    assert other_peak == pytest.approx(peak, rel=PEAK)
    assert other_frequency == pytest.approx(frequency, abs=FREQUENCY)
    for curve in curves:
        assert np.abs(curve.receptance(request.points[0])).max() == pytest.approx(peak, rel=PEAK)


@pytest.mark.long
def test_neither_do_two_threads(upwards):
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "2")
    ran = subprocess.run(
        [sys.executable, "-c", TWO_THREADS, str(OPENS_EARLY)],
        env={**os.environ, **threads},
        capture_output=True,
        text=True,
        check=True,
    )
    found = json.loads(ran.stdout.splitlines()[-1])
    one = upwards("IP", 9.6)
    assert_same(Reading(**found), Reading(**json.loads(json.dumps(asdict(one)))))


@pytest.mark.long
def test_the_resonance_followed_in_force_is_the_peak_of_the_curves_however_many_contacts_open(rig, reduced, upwards):
    """IP, whose contacts open one after another."""
    model, tip = rig_model(reduced, static_contact(reduced, rig), rig), f"blade_{rig.excitation.blade}.tip.x"
    window = rig.study.modes["IP"].window
    asked = ResonanceRequest("IP", model.excitation, tip, window, (0.96, 3.84, 9.6, 17.0), MaximumResonance())
    *_, followed = trace_resonance(model.system, asked)
    assert followed.complete, followed.stopped
    at = followed.at_forces()
    for i, force in enumerate(asked.forces):
        curve = upwards("IP", force)
        assert abs(at.receptance[i]) == pytest.approx(curve.peak, rel=PEAK)
        assert at.frequency[i] == pytest.approx(curve.frequency, abs=FREQUENCY)


def assert_same(found: Reading, first: Reading) -> None:
    assert found.complete == first.complete
    assert found.peak == pytest.approx(first.peak, rel=PEAK)
    assert found.frequency == pytest.approx(first.frequency, abs=FREQUENCY)
    for name in ("up", "down", "resonances"):
        assert list(getattr(found, name)) == pytest.approx(list(getattr(first, name)), abs=FREQUENCY), name
