"""Sweeps of the virtual laboratory where the response jumps: motions between two folds are found, and not stayed in."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.plain_rig import TINY

from updamp.benchmarks.virtual_rig.assembled import Assembled, assembled
from updamp.benchmarks.virtual_rig.bench import bench_of
from updamp.benchmarks.virtual_rig.bodies import bodies_of
from updamp.benchmarks.virtual_rig.periodic import Motion, SolverOptions
from updamp.benchmarks.virtual_rig.stepped_sine import StepMotor
from updamp.model.rig_files import load_rig

SHORT_FACES = Path(__file__).parents[1] / "data" / "short_faces.toml"
FORCE, TIP = 4.0, "blade_right.tip.x"
QUICK = SolverOptions(harmonics=3, n_time=128, tolerance=1e-8)


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Assembled:
    sizes = {"mesh.tiny": TINY, "reduction.modes": 10}
    jumping = load_rig(SHORT_FACES, {**sizes, "harmonic_balance.harmonics": [1, 2, 3]})
    return assembled(bench_of(jumping, bodies_of(jumping, "tiny", tmp_path_factory.mktemp("bodies"))))


@pytest.fixture(scope="module")
def place(rig: Assembled) -> float:
    """Inside the hysteresis of the in-phase mode [Hz]"""
    return 0.993 * float(rig.stuck_frequencies(1)[0])


def swept(rig: Assembled, start: float, place: float) -> StepMotor:
    motor = StepMotor(rig, QUICK)
    for frequency in np.linspace(start, place, 15):
        motor.step(float(frequency), FORCE)
    return motor


def between(upper: StepMotor) -> Motion:
    """The motion between the folds, about as large as the upper one, on the other side of resonance: a part of a
    period later."""
    motion = upper.motion
    assert motion is not None
    later = motion.x.copy().view(complex) * np.exp(2.2j * np.arange(1, QUICK.harmonics + 1))
    return upper.settled(motion.w, FORCE, later.view(float))


@pytest.fixture
def upper(rig: Assembled, place: float) -> StepMotor:
    return swept(rig, 1.014 * place, place)


def test_the_motion_between_two_folds_is_unstable_and_the_others_are_not(
    rig: Assembled, place: float, upper: StepMotor
) -> None:
    lower = swept(rig, 0.985 * place, place)
    assert upper.motion is not None
    assert lower.motion is not None
    middle = between(upper)
    phases = [np.angle(m.response(TIP)[0]) for m in (upper.motion, middle, lower.motion)]
    assert phases == pytest.approx([-2.69, -0.44, -0.05], abs=0.03)
    unstable = [upper.is_unstable(m) for m in (upper.motion, middle, lower.motion)]
    assert unstable == [False, True, False]


@pytest.mark.parametrize("held", [0.994, 0.997, 1.0, 1.003, 1.006])
def test_a_sweep_does_not_leap_between_the_folds(held: float, place: float, upper: StepMotor) -> None:
    """The way there is laid: the last motion but one is put where it leads straight to the one between."""
    last = upper.motion
    assert last is not None
    middle = between(upper)
    upper.before = replace(last, w=1.001 * last.w, x=2 * last.x - middle.x)
    following = upper.step(0.999 * place, held * FORCE)
    assert np.angle(following.response(TIP)[0]) == pytest.approx(-2.69, abs=0.03)
