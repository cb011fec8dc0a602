"""Three masses in a chain with two Jenkins elements, two cubic springs and a unilateral spring: NLvib's example 7
(M. Krack and J. Gross, Harmonic Balance for Nonlinear Vibration Problems, Springer 2019), traced over frequency."""

import jax.numpy as jnp
import numpy as np

from updamp.hbm.contact.jenkins import Jenkins, JenkinsParameters
from updamp.hbm.contact.springs import CubicParameters, CubicSpring, UnilateralParameters, UnilateralSpring
from updamp.hbm.continuation.continuation import ContinuationOptions
from updamp.hbm.continuation.curve import CurveRequest, whole_curve
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.system import Excitation, NonlinearSystem

chain = 2 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)
points = {"q1": np.eye(3)[0], "q2": np.eye(3)[1], "q3": np.eye(3)[2]}
directions = np.array([[1, 0, 0], [-1, 1, 0], [0, 1, 0], [0, -1, 1], [0, 0, 1]])  # one row an element
linear = from_matrices(np.eye(3), 0.02 * chain, chain, directions, points)
elements = (
    ElementGroup(Jenkins(), JenkinsParameters(kt=jnp.full(2, 20.0), limit=jnp.ones(2)), np.array([[0], [1]])),
    ElementGroup(CubicSpring(), CubicParameters(jnp.ones(2)), np.array([[2], [3]])),
    ElementGroup(UnilateralSpring(), UnilateralParameters(jnp.ones(1), gap=jnp.full(1, 0.25)), np.array([[4]])),
)
system = NonlinearSystem(linear, elements, Harmonics(tuple(range(8))), time_samples=1024)
window, options = (0.5 / (2 * np.pi), 2 / (2 * np.pi)), ContinuationOptions(largest_step=0.05)
request = CurveRequest("chain", Excitation(linear.row("q2"), 1.0), window, tuple(points), options=options)

if __name__ == "__main__":
    curve = whole_curve(system, request)
    for point in points:
        print(f"{point}: largest first harmonic %.4g m/N at %.4g Hz" % curve.peak(point)[::-1])
