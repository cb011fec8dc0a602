"""Faults of the measurement: nothing at null, as their formulas say at any size, and with the right derivatives."""

from pathlib import Path

import numpy as np
import pint
import pytest

from updamp.comparison.fit.observations import plan_of
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.comparison.prediction.run_condition import HeldResponse, RunCondition
from updamp.comparison.prediction.traced_branch import trace_branch
from updamp.diagnosis.candidate_models.baseline import baseline
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.decision.conclude import conclude
from updamp.diagnosis.decision.decide import decide
from updamp.diagnosis.selection.search import search
from updamp.effects.catalogue import CATALOGUE, FAULTS, JOINTS, catalogue
from updamp.effects.rig_model import RigModel
from updamp.measurement.measurement import Channel, MeasuredRun, Measurement
from updamp.model.build import modal_model
from updamp.model.calibration import nuisances
from updamp.model.rig_files import load_modal

UNITS = pint.get_application_registry()  # one for all: to make one takes half a second

POINT, FORCE = "beam.drive.x", 0.2
MASS, RESONANCE, LOSS = 2.0, 80.38, 0.0031  # of rigs/brake_reuss.toml
UP = RunCondition("up", "first", FORCE, True, (79.0, 81.5), ((POINT, 1),))
DOWN = RunCondition("down", "first", FORCE, False, (79.0, 81.5), ((POINT, 1),))
HELD = RunCondition("held", "first", FORCE, True, (79.0, 81.5), ((POINT, 1),), control=HeldResponse(POINT, 40.0, 2))
CONDITIONS = pytest.mark.parametrize("condition", [UP, DOWN, HELD], ids=lambda c: c.name)
NAMES = (
    "phase_lag",
    "sensor_delay",
    "feed_through",
    "sensor_gain",
    "amplifier_drift",
    "resonance_drift",
    "sensor_compression",
)


@pytest.fixture(scope="module")
def beam() -> RigModel:
    return modal_model(load_modal(Path(__file__).parents[2] / "rigs" / "brake_reuss.toml"))


def parametrised(beam: RigModel, name: str) -> Parametrisation:
    return Parametrisation(beam, nuisances(beam), (JOINTS["joint_cubic"], FAULTS[name]))


def branch(beam: RigModel, name: str, sizes: float | np.ndarray, condition: RunCondition) -> PredictedBranch:
    """sizes: of the fault's parameters, in typical ones"""
    p = parametrised(beam, name)
    u = np.zeros(len(p))
    u[p.columns(name)] = sizes
    return trace_branch(p, u, condition)


def linear(f: np.ndarray) -> np.ndarray:
    w, w0 = 2 * np.pi * f, 2 * np.pi * RESONANCE
    return FORCE / MASS / (w0**2 * (1 + 1j * LOSS) - w**2)


def test_they_are_a_class_of_their_own() -> None:
    assert tuple(FAULTS) == NAMES
    assert not set(FAULTS) & (set(CATALOGUE) | set(JOINTS))
    assert set(catalogue()) >= set(FAULTS)
    for effect in FAULTS.values():
        assert effect.in_words.startswith("fault of the measurement: ")
        for p in effect.parameters:
            assert p.lower < p.null < p.typical < p.upper
            assert (1 * UNITS.parse_units(p.unit)).to_base_units().magnitude == pytest.approx(1)


@CONDITIONS
@pytest.mark.parametrize("name", NAMES)
def test_at_null_what_is_read_is_the_motion(beam: RigModel, name: str, condition: RunCondition) -> None:
    found = branch(beam, name, 0.0, condition)
    np.testing.assert_allclose(found.amplitude[:, 0], linear(found.frequency), rtol=1e-7)


@CONDITIONS
def test_what_is_read_is_what_the_formulas_say(beam: RigModel, condition: RunCondition) -> None:
    def read(name: str) -> tuple[np.ndarray, np.ndarray]:
        found = branch(beam, name, 1.0, condition)
        return found.frequency, found.amplitude[:, 0]

    f, y = read("phase_lag")
    np.testing.assert_allclose(y, linear(f) * np.exp(-0.1j), rtol=1e-7)
    f, y = read("sensor_delay")
    np.testing.assert_allclose(y, linear(f) * np.exp(-2j * np.pi * f * 2e-4), rtol=1e-7)
    f, y = read("feed_through")
    np.testing.assert_allclose(y, linear(f) + (1 + 1j) * 1e-5 * FORCE, rtol=1e-7)
    f, y = read("sensor_gain")
    np.testing.assert_allclose(y, linear(f) * 1.05, rtol=1e-7)
    f, y = read("sensor_compression")
    short = 0.0 if condition.control is not None else 5e6
    np.testing.assert_allclose(y, linear(f) * np.exp(-short * np.abs(linear(f)) ** 2), rtol=1e-7)
    f, y = read("amplifier_drift")
    start, end = condition.window if condition.upwards else condition.window[::-1]
    done = np.log(f / start) / np.log(end / start)
    np.testing.assert_allclose(y, linear(f) * np.exp(0.05 * done), rtol=1e-7)
    f, y = read("resonance_drift")
    rate = 5e-4 / np.log(
        end / start
    )  # log f is read where the motion is that of log f0 = log f - rate (log f0 - log start)
    at = start * (f / start) ** (1 / (1 + rate))
    np.testing.assert_allclose(y, linear(at), rtol=1e-7)


@CONDITIONS
@pytest.mark.parametrize("name", NAMES)
def test_slopes_are_those_of_branches_traced_anew(beam: RigModel, name: str, condition: RunCondition) -> None:
    """By the fault's parameters, by the modal mass and along the branch, as changes at the same frequency."""
    p, step = parametrised(beam, name), 1e-3
    u = np.zeros(len(p))
    u[p.columns(name)] = 1.0
    found = trace_branch(p, u, condition)
    inside = (found.frequency > 79.2) & (found.frequency < 81.3)
    value, slopes, along = (
        part[inside] for part in (found.observed.value, found.observed.slopes, found.observed.along)
    )
    for j in (2, *range(p.columns(name).start, p.columns(name).stop)):
        moved = u.copy()
        moved[j] += step
        there = trace_branch(p, moved, condition)
        difference = value_at(there, value[:, 0]) - value_at(found, value[:, 0])
        slope = slopes[:, j] - slopes[:, j, :1] / along[:, :1] * along  # along the branch to the same frequency
        np.testing.assert_allclose(difference / step, slope[:, 1:], atol=2e-3 * np.abs(slope[:, 1:]).max())


def test_a_lag_is_nothing_in_amplitudes(beam: RigModel) -> None:
    """But for round-off, 1e-16 over a step of 1e-5: to first order, as a finite step would not have it."""
    found = branch(beam, "phase_lag", 0.0, UP)
    (lag,) = range(*parametrised(beam, "phase_lag").columns("phase_lag").indices(99))
    slopes = found.observed.slopes[:, lag]
    np.testing.assert_allclose(slopes[:, 2], -0.1, rtol=1e-9)
    assert np.abs(slopes[:, :2]).max() < 1e-10


def value_at(branch: PredictedBranch, log_f: np.ndarray) -> np.ndarray:
    """Logarithm of amplitude and phase at frequencies of a branch that does not turn."""
    dense = np.linspace(branch.place[0], branch.place[-1], 40_000)
    value = branch.at(dense).value
    order = np.argsort(value[:, 0])
    return np.stack([np.interp(log_f, value[order, 0], np.unwrap(value[:, k])[order]) for k in (1, 2)], axis=1)


def measured(lag: float) -> Measurement:
    """Two levels of a linear resonator, noise of 0.3 %, read with a lag [rad]. No code of updamp."""
    rng, runs, f = np.random.default_rng(3), [], RESONANCE * np.linspace(0.985, 1.015, 31)
    for force in (1.0, 5.0):
        x = force / FORCE * linear(f) * np.exp(-1j * lag)
        x = x * (1 + 0.003 * (rng.standard_normal(len(f)) + 1j * rng.standard_normal(len(f))))
        drive = np.full(len(f), force + 0j)
        runs.append(
            MeasuredRun(f"{force:g} N", "first", True, "force", force, 1, ("a",), (1,), f, drive, x[None, None])
        )
    return Measurement("resonator", 0.0, POINT, (Channel("a", POINT),), tuple(runs), repeatability=0.01)


@pytest.mark.long
@pytest.mark.parametrize("lag", [0.0, 0.12])
def test_a_lag_is_found_among_all_effects_and_none_where_none_is(beam: RigModel, lag: float) -> None:
    start = baseline(beam, (), plan_of(measured(lag)), {})
    found = search(start, (*JOINTS.values(), *FAULTS.values()), Criteria())
    decision = decide(found.evidence, Criteria())
    if lag == 0:
        assert (decision.outcome, decision.effects) == ("adequate", ())
        return
    assert "phase_lag" in decision.effects
    verdict = conclude(found, decision, Criteria(), {POINT: "a"})
    assert "fault of the measurement: every response lags" in verdict.sentence or decision.outcome == "inseparable"
    (said,) = (c for c in verdict.candidates if c.name == "phase_lag")
    assert said.parameters[0].value == pytest.approx(lag, abs=0.005)
    assert said.parameters[0].lower < lag < said.parameters[0].upper
