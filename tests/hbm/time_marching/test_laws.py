"""Laws of a step against the laws of a period that they are written beside, and their tangents against differences."""

import jax
import numpy as np
import pytest

from updamp.hbm.contact.coulomb_circle import CoulombCircle
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.jenkins import Jenkins, JenkinsParameters
from updamp.hbm.contact.jenkins_box_sampled import SampledJenkinsBox
from updamp.hbm.contact.springs import CubicParameters, CubicSpring, UnilateralParameters, UnilateralSpring
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.time_marching.contacts import Contacts

N = 40
RNG = np.random.default_rng(3)
PARAMETERS = FrictionParameters(
    mu=RNG.uniform(0.1, 0.6, N), kt=RNG.uniform(1, 3, N), kn=RNG.uniform(1, 3, N), n0=RNG.uniform(0, 1, N),
    t0=RNG.uniform(-0.05, 0.05, (N, 2)), gap=RNG.uniform(0, 0.2, N),
)  # fmt: skip
LAWS = {
    "box": (SampledJenkinsBox(), PARAMETERS),
    "circle": (CoulombCircle(2), PARAMETERS),
    "jenkins": (Jenkins(), JenkinsParameters(RNG.uniform(1, 3, N), RNG.uniform(0.2, 1, N))),
    "cubic": (CubicSpring(), CubicParameters(RNG.uniform(-1, 1, N))),
    "unilateral": (UnilateralSpring(), UnilateralParameters(RNG.uniform(1, 3, N), RNG.uniform(-0.3, 0.3, N))),
}


@pytest.fixture(params=LAWS)
def case(request):
    """Law and parameters, the contacts in time, and a period of motion (n_time, n_rows)."""
    law, parameters = LAWS[request.param]
    rows = np.arange(N * law.directions).reshape(N, law.directions)
    phase = 2 * np.pi * np.arange(64) / 64
    motion = sum(np.outer(np.cos(k * phase + k), RNG.normal(size=rows.size)) / k for k in (1, 2, 3)) / 2
    return law, parameters, Contacts.of((ElementGroup(law, parameters, rows),)), motion


def test_forces_over_a_settled_period_are_those_of_the_law(case):
    law, parameters, contacts, motion = case
    samples = np.moveaxis(motion.reshape(64, N, -1), 1, 0)
    expected = jax.vmap(law.force)(samples, 0 * samples, parameters)
    sliders = tuple(one.at_rest() for one in contacts.laws)
    for _ in range(2):  # cycles of the law
        found = []
        for u in motion:
            force, (step,) = contacts.step(u, sliders)
            sliders = (step.slider,)
            found.append(force)
    np.testing.assert_allclose(np.array(found), np.moveaxis(np.asarray(expected), 0, 1).reshape(64, -1), atol=1e-12)


def test_tangents_are_differences(case):
    """Where no element changes its state within the difference."""
    _, _, contacts, motion = case
    sliders, u, small = contacts.along(motion), motion[5], 1e-7
    _, (step,) = contacts.step(u, sliders)
    d = step.tangent.shape[1]
    for j in range(d):
        move = np.zeros((N, d))
        move[:, j] = small
        ahead, behind = (contacts.step(u + sign * move.ravel(), sliders)[1][0].force for sign in (1, -1))
        difference = (ahead - behind) / (2 * small)
        close = np.abs(difference - step.tangent[:, :, j]).max(axis=1) < 1e-6
        assert close.mean() > 0.95
