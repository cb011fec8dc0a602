"""A quick model of a test: two masses on springs with a friction contact between them, and synthetic runs of it."""

import jax.numpy as jnp
import numpy as np

from updamp.comparison.fit.observations import Observations, Plan
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.comparison.prediction.traced_branch import trace_branch
from updamp.effects.rig_model import RigModel
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.model.calibration import FRICTION, LOSS_FACTOR, PRELOAD, YOUNGS_MODULUS

SENSORS = (("a.x", 1), ("b.x", 1))
# Standard deviation of amplitudes, relative, and of phases.
NOISE = 0.005
NUISANCES = (YOUNGS_MODULUS, LOSS_FACTOR, FRICTION, PRELOAD)


def small_model() -> RigModel:
    """Masses a and b of 1 kg, 40 and 45 Hz alone, loss factor 1 %; between them a contact in t1 (t2 and n are held)."""
    K = np.diag([(2 * np.pi * 40) ** 2, (2 * np.pi * 45) ** 2, 1e6, 1e6])
    relative = np.array([[1.0, -1.0, 0, 0], [0, 0, 1.0, 0], [0, 0, 0, 1.0]])
    linear = from_matrices(np.eye(4), 0 * K, K, relative, {"a.x": np.eye(4)[0], "b.x": np.eye(4)[1]})
    linear = type(linear)(**{**vars(linear), "hysteretic": 0.01 * np.diag(linear.omega_squared)})
    one = jnp.ones(1)
    parameters = FrictionParameters(0.5 * one, 2e4 * one, 1e6 * one, 40 * one, jnp.zeros((1, 2)), 0 * one)
    contacts = ElementGroup(JenkinsBox(), parameters, np.array([[0, 1, 2]]))
    return RigModel(linear, ("body",) * 4, (), contacts, None, "a.x", Harmonics((1, 3)), 128)


def parametrisation() -> Parametrisation:
    return Parametrisation(small_model(), NUISANCES)


def condition(force: float, upwards: bool = True, window: tuple[float, float] = (40.0, 50.0)) -> RunCondition:
    return RunCondition(f"{force:g} N", "first", force, upwards, window, SENSORS, noise=(2e-6, *4 * (NOISE,)))


def synthetic_plan(
    truth: Parametrisation,
    u: np.ndarray,
    conditions: tuple[RunCondition, ...],
    scatter: np.ndarray,
    seed: int,
    noise: float = NOISE,
    repeats: int = 3,
    points: int = 40,
) -> tuple[Plan, np.ndarray]:
    """Runs of `repeats` assemblies with scattered parameters, drift 5e-5, gain 0.5 %; and the assemblies' offsets."""
    rng = np.random.default_rng(seed)
    runs, drawn = [], []
    for repeat in range(1, repeats + 1):
        b = scatter * rng.standard_normal(len(scatter))
        gain = 0.005 * rng.standard_normal(len(SENSORS))
        drawn.append(b)
        assembly = Parametrisation(truth.model(u + b), ())  # nothing free: no derivatives are asked for
        for i, c in enumerate(conditions):
            branch = trace_branch(assembly, np.zeros(0), c)
            runs.append(swept_run(branch, i, repeat, gain, noise, rng, points))
    return Plan(conditions, tuple(runs)), np.array(drawn)


def swept_run(branch, test, repeat, gain, noise, rng, points=40):
    """Stepped sine over the visited part."""
    place = np.linspace(branch.place[0], branch.place[-1], 4000)
    visited = np.interp(place, branch.place, branch.visited) > 0.99
    low, high = branch.condition.window
    steps = np.linspace(low, high, points) if branch.condition.upwards else np.linspace(high, low, points)
    drift = 5e-5 * rng.standard_normal()
    frequency = np.exp(branch.at(place).value[:, 0] + drift)
    usable = np.flatnonzero(visited)
    at = np.array([usable[np.argmin(np.abs(frequency[usable] - f))] for f in steps])
    observed = branch.at(place[at]).value
    observed[:, 0] += drift
    gain = gain[: observed.shape[1] // 2]
    observed[:, 1::2] += gain
    observed[:, 1:] += noise * rng.standard_normal(observed[:, 1:].shape)
    deviations = np.column_stack([np.full(points, 2e-6), *(np.full(points, noise) for _ in range(2 * len(gain)))])
    return Observations(branch.condition.name, test, repeat, observed, deviations, np.zeros(points))
