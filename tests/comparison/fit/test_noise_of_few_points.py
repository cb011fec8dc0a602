"""The noise of a run that has few points, from what a model leaves of it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.jumping_beam import Joint, Mode, measured

from updamp.comparison.fit.fit_from_far import fit_from_far
from updamp.comparison.fit.noise_by_amplitude import noise_of_each_sensor, with_noise_of_sensors
from updamp.comparison.fit.observations import Plan, plan_of
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.model.build import modal_before_effects
from updamp.model.calibration import OF_MODES
from updamp.model.rig_files import load_modal

MODEL = modal_before_effects(load_modal(Path(__file__).parents[3] / "rigs" / "brake_reuss.toml"))
BEAM, WINDOW = Mode(80.38, 0.0031, 2.0), (79.9, 80.9)
NOISE = 0.015


def plan(points: int, joint: Joint = Joint(), repeatability: float = 0.0) -> Plan:
    """Eight runs of one assembly, whose noise is not stated"""
    forces = tuple(0.5 + 0.05 * i for i in range(8))
    return plan_of(
        replace(measured((BEAM,), joint, WINDOW, forces, True, points, NOISE, 3), repeatability=repeatability)
    )


def read_off(runs: Plan) -> tuple[float, float]:
    """Noise as the runs themselves have it (median of their values), and as what the calibrated model leaves, over the
    true one"""
    p = Parametrisation(MODEL, OF_MODES)
    found = fit_from_far(p, runs, np.zeros(len(p))).compared
    read_again = with_noise_of_sensors(runs, noise_of_each_sensor(found.matched, runs))
    noises = [np.concatenate([o.noise[:, 1] for o in each.observations]) / NOISE for each in (runs, read_again)]
    return float(np.median(noises[0])), float(np.median(noises[1]))


@pytest.mark.parametrize("points", [12, 40])
def test_few_points_tell_the_noise_as_many_do(points: int) -> None:
    """To two deviations of the estimate, 1.5 over the root of the number of differences."""
    of_runs, of_model = read_off(plan(points))
    assert of_model == pytest.approx(1.0, abs=3.0 / np.sqrt(8 * 2 * (points - 3)))
    assert (of_runs > 1.4) == (points == 12), "the resonance itself is as rough"


def test_a_misfit_is_no_noise() -> None:
    """A spring is missing that moves the resonance by a third of its width."""
    _, of_model = read_off(plan(40, Joint(cubic=1e9)))
    assert of_model == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize(("stated", "counts"), [(NOISE / 5, 1.0), (NOISE, 1.0), (3 * NOISE, 3.0)])
def test_what_tests_are_stated_to_differ_by_has_the_noise_in_it(stated: float, counts: float) -> None:
    """It is the least that errors are measured in: less than the runs are rough, and their noise counts."""
    runs = plan(12, repeatability=stated)
    _, of_model = read_off(runs)
    # of those that are larger than what is stated, by chance
    assert of_model == pytest.approx(counts, abs=3.0 / np.sqrt(8 * 2 * (12 - 3)))
    np.testing.assert_allclose(runs.if_repeatable(0.0).own_noise, plan(12).own_noise)
    assert runs.told_by_noise == (stated < 3 * NOISE)
    assert np.isinf(runs.noise_freedom) == (stated == 3 * NOISE)
    if stated != NOISE:  # where a model has not taken the resonance off, twelve points are rougher than their noise
        assert runs.rougher_than_stated == (stated < NOISE)


def test_a_noise_that_is_stated_stays() -> None:
    runs = replace(plan(12), noise_read=False)
    assert noise_of_each_sensor((), runs) == {}
