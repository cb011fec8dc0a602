"""Three masses of three directions each between friction contacts, their own mirror image across a plane."""

import numpy as np

from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.mirror import Mirror
from updamp.hbm.problem.system import NonlinearSystem

# Elements 0 and 1 are images of each other, 2 lies in the plane; of the displacements across it the sign changes.
IMAGE, SIGN = np.array([3, 4, 5, 0, 1, 2, 6, 7, 8]), np.tile([1.0, -1.0, 1.0], 3)
MIRROR = Mirror(IMAGE, SIGN)
WINDOW = (0.2, 0.34)


def three_masses(
    kn: tuple[float, float, float] = (2.0, 2.0, 1.0),
    off: float = 0.0,
    last_digit: int | None = None,
    mirror: Mirror | None = MIRROR,
) -> NonlinearSystem:
    """Driven in the plane between the outer two ("drive"), or at one of them ("side").

    off: stiffness that breaks the symmetry; last_digit: seed of a change of the stiffness by round-off
    """
    part = np.random.default_rng(3).normal(size=(9, 9))
    stiffness = part @ part.T / 9 + 2 * np.eye(9)
    reflection = np.zeros((9, 9))
    reflection[np.arange(9), IMAGE] = SIGN
    stiffness = (stiffness + reflection @ stiffness @ reflection.T) / 2
    stiffness[0, 0] += off
    if last_digit is not None:
        change = 1e-15 * np.random.default_rng(last_digit).normal(size=(9, 9))
        stiffness = stiffness * (1 + change + change.T)
    points = {"drive": np.eye(9)[6], "side": np.eye(9)[0]}
    linear = from_matrices(np.eye(9), 0.02 * np.eye(9), stiffness, np.eye(9), points)
    own = np.array(kn)
    parameters = FrictionParameters(np.full(3, 0.4), own, own, np.full(3, 0.3), np.zeros((3, 2)), np.zeros(3))
    group = ElementGroup(JenkinsBox(2), parameters, np.arange(9).reshape(3, 3))
    return NonlinearSystem(linear, (group,), Harmonics((0, 1, 2, 3)), 64, mirror)
