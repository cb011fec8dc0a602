"""Three modes and a friction contact as matrices: curve, peak, jumps, error, stability, and the resonance by force."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np

from updamp.hbm.analysis.finer_curve import curve_error
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.continuation.curve import CurveRequest, whole_curve
from updamp.hbm.continuation.sweeps import swept
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.system import Excitation, NonlinearSystem
from updamp.hbm.resonance.conditions import MaximumResonance
from updamp.hbm.resonance.resonance_curve import ResonanceRequest, whole_resonance
from updamp.hbm.stability.branch_stability import State, branch_stability

# M u'' + C u' + K u + forces of the elements = load; SI. Rows: (t1, t2, n) of the one contact; the tip.
M, K = np.eye(3), np.diag([4.0e5, 9.0e5, 1.6e6])
directions = np.array([[1, 0.2, 0], [0, 1, 0], [0, 0.3, 1]])
linear = from_matrices(M, 2e-6 * K, K, directions, {"tip": np.array([1, 0.5, 0])})
one = jnp.ones(1)
contact = FrictionParameters(
    mu=0.5 * one, kt=1e5 * one, kn=2e5 * one, n0=20.0 * one, t0=jnp.zeros((1, 2)), gap=0.0 * one
)
elements = (ElementGroup(JenkinsBox(), contact, rows=np.array([[0, 1, 2]])),)
system = NonlinearSystem(linear, elements, Harmonics((0, 1, 2, 3)), time_samples=128)
force, window = Excitation(linear.row("tip"), force=5.0), (90.0, 130.0)
request = CurveRequest("first bending", force, window, points=("tip",), told=("tip",))

if __name__ == "__main__":
    curve = whole_curve(system, request)
    print("complete" if curve.complete else f"not complete: {curve.stopped}")
    at, peak = curve.peak("tip")
    print(f"peak at {at:.4f} Hz, {peak:.4g} m/N")
    print("jumps of a sweep upwards [Hz]:", swept(curve, upwards=True).jumps)
    finer = whole_curve(replace(system, harmonics=Harmonics(tuple(range(8))), time_samples=512), request)
    print(f"more harmonics and samples change the peak by {curve_error(curve, finer, 'tip').peak_percent:.2g} %")
    states = branch_stability(system, curve, "tip").state
    print({state.name.lower(): int(np.sum(states == state)) for state in State})
    asked = ResonanceRequest("first bending", "tip", "tip", window, (0.5, 1.0, 2.0, 5.0, 10.0), MaximumResonance())
    backbone = whole_resonance(system, asked).at_forces()
    for level, at, receptance in zip(backbone.force, backbone.frequency, np.abs(backbone.receptance), strict=True):
        print(f"resonance at {level:g} N: {at:.4f} Hz, {receptance:.4g} m/N")
