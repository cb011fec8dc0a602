"""Peaks of a hardening oscillator: followed in the force or read off the curve they agree; and where it jumps."""

from dataclasses import replace

import numpy as np
import pytest
from support.modal_study import RIG, write_study
from support.study_runs import run

from updamp.design import solved_design
from updamp.design.solved_peak import FollowedPeaks, followed_peaks
from updamp.hbm.continuation.curve import whole_curve
from updamp.hbm.resonance.resonance_curve import COLUMNS

CUBIC = '[[effects]]\nname = "joint_cubic"\nvalues = { coefficient = "1e11 N/m^3" }\n'

STUDY = """
[study]
rig = "beam.toml"
out = "out"

[[variables]]
name = "loss"
path = "modes.first.loss_factor"
lower = 0.003
upper = 0.01

[[responses]]
name = "followed"
kind = "peak_receptance"
mode = "first"
force = "1 N"

[[responses]]
name = "read_off"
kind = "peak_receptance"
mode = "first"
force = "1 N"
by = "curve"

[[responses]]
name = "at"
kind = "resonance_frequency"
mode = "first"
force = "1 N"

[[responses]]
name = "shift"
kind = "frequency_shift"
mode = "first"
force = "1 N"

[[responses]]
name = "jump"
kind = "jump_frequency"
mode = "first"
force = "1 N"

[[responses]]
name = "jumps_down"
kind = "jump_count"
mode = "first"
force = "1 N"
sweep = "down"
"""


@pytest.fixture
def hardening(folder):
    (folder / "beam.toml").write_text(RIG + CUBIC)
    return write_study(folder, 'kind = "grid"\npoints = 2', text=STUDY)


def test_peak_and_jump_are_the_same_by_all_ways(hardening):
    lightly, heavily = run(hardening).records
    assert lightly.values["loss"] < heavily.values["loss"]
    for one in (lightly, heavily):
        assert one.responses["followed"] == pytest.approx(one.responses["read_off"], rel=1e-3)
        stiffness = 2.0 * (2 * np.pi * one.responses["at"]) ** 2
        loss = one.values["loss"] * (80 / one.responses["at"]) ** 2  # hysteretic damping is that of the modal stiffness
        assert one.responses["followed"] == pytest.approx(1e3 / (stiffness * loss), rel=2e-3), "mm/N"
        amplitude = 1e-3 * one.responses["followed"]
        hardened = 80 * np.sqrt(1 + 0.75 * 1e11 * amplitude**2 / (2.0 * (2 * np.pi * 80) ** 2))
        assert one.responses["at"] == pytest.approx(hardened, rel=1e-3)
        assert one.responses["shift"] == pytest.approx(one.responses["at"] - 80, abs=0.01)
    assert lightly.responses["jump"] == pytest.approx(lightly.responses["at"], rel=1e-3), "it falls off its peak"
    assert lightly.responses["jumps_down"] == 1
    assert heavily.responses["jump"] is None
    assert heavily.unknown["jump"] == "a sweep up jumps 0 times"
    assert heavily.outcome == "partly"
    assert set(lightly.routes.values()) == {"resonance", "curve"}


def stopping(model, request):
    """A resonance that meets none of its forces."""
    met = followed_peaks(model, request).met
    none = {name: getattr(met, name)[:0] for name in COLUMNS}
    return FollowedPeaks(replace(met, **none, complete=False, stopped="the resonance stops at 0.5 N"), False)


def test_where_following_stops_the_curve_is_taken_and_it_is_said(hardening, monkeypatch):
    followed = run(hardening, out=hardening.parent / "before").records
    monkeypatch.setattr(solved_design, "followed_peaks", stopping)
    for one, before in zip(run(hardening).records, followed, strict=True):
        assert one.responses["followed"] == pytest.approx(before.responses["followed"], rel=1e-3)
        assert "first 1 N: curve, since the resonance stops at 0.5 N" in [f"{a}: {b}" for a, b in one.routes.items()]


def test_nothing_falls_back_that_is_not_to(hardening, monkeypatch):
    hardening.write_text(hardening.read_text().replace('force = "1 N"\n', 'force = "1 N"\nby = "resonance_only"\n', 1))
    monkeypatch.setattr(solved_design, "followed_peaks", stopping)
    for one in run(hardening).records:
        assert one.unknown["followed"] == "the resonance stops at 0.5 N"
        assert one.responses["read_off"] is not None


def test_a_curve_that_is_not_complete_has_no_peak(hardening, monkeypatch):
    def cut_off(system, request):
        yield replace(whole_curve(system, request), complete=False, stopped="it stopped at 81 Hz")

    monkeypatch.setattr(solved_design, "trace", cut_off)
    for one in run(hardening).records:
        assert one.responses["read_off"] is None
        assert one.unknown["read_off"] == "the curve first at 1 N is not complete: it stopped at 81 Hz"
        assert one.responses["followed"] is not None
        assert one.outcome == "partly"


def test_what_takes_more_points_than_the_study_allows_is_not_known(hardening):
    whole = run(hardening, out=hardening.parent / "before").records
    hardening.write_text(hardening.read_text().replace('out = "out"\n', 'out = "out"\nmost_points = 10\n'))
    for one, before in zip(run(hardening).records, whole, strict=True):
        assert one.setup != before.setup, "another limit is another study"
        assert one.responses["followed"] is None
        assert one.unknown["followed"].startswith("the resonance was given up: it took more than 10 points, the last")
        assert one.unknown["read_off"] == "the curve first at 1 N is not complete: it was given up after 10 points"
        assert before.responses["followed"] is not None
