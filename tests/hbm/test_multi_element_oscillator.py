"""The example with five nonlinear elements, against the equations of NLvib's example 7 written out a second time."""

import runpy
from pathlib import Path

import numpy as np
import pytest

from updamp.hbm.continuation.curve import trace

EXAMPLE = Path(__file__).parents[2] / "examples" / "multi_element_oscillator.py"
CHAIN = np.array([[2.0, -1, 0], [-1, 2, -1], [0, -1, 2]])
JENKINS = np.array([[1.0, 0, 0], [-1, 1, 0]])
CUBIC = np.array([[0.0, 1, 0], [0, -1, 1]])


@pytest.fixture(scope="module")
def curve():
    example = runpy.run_path(str(EXAMPLE))
    *_, curve = trace(example["system"], example["request"])
    return curve


def element_forces(q):
    """(n_time, 3) forces of all elements on the masses; q (n_time, 3). Two periods of the sliders, as NLvib marches."""
    n = len(q)
    force = (q @ CUBIC.T) ** 3 @ CUBIC
    force[:, 2] += np.maximum(q[:, 2] - 0.25, 0.0)
    u, slider, friction = q @ JENKINS.T, np.zeros(2), np.zeros((n, 2))
    for i in range(1, 2 * n):
        friction[i % n] = np.clip(20.0 * (u[i % n] - slider), -1.0, 1.0)
        slider = u[i % n] - friction[i % n] / 20.0
    return force + friction @ JENKINS


def test_example_is_short():
    assert len(EXAMPLE.read_text().splitlines()) < 40


def test_it_goes_through_the_whole_window_and_past_a_turning_point(curve):
    assert curve.complete
    assert 2 * np.pi * curve.frequency[0] == pytest.approx(0.5)
    # traced from both ends: the last point is the first one of the piece from above, at the window's end
    assert 2 * np.pi * curve.frequency[-1] >= 2.0 * (1 - 1e-12)
    assert (np.diff(curve.frequency) < 0).any()


def test_every_point_solves_the_equations_of_motion(curve):
    """M q'' + 0.02 K q' + K q + f(q) = cos(w t) on the second mass, in each of the harmonics 0 to 7."""
    harmonics, n = curve.harmonics, 1024
    for i in range(0, len(curve), 5):
        w = 2 * np.pi * curve.frequency[i]
        q = curve.response[i] @ harmonics.synthesis(n).T
        forces = harmonics.analysis(n) @ element_forces(q.T)
        for k in range(8):
            stiffness = CHAIN * (1 + 0.02j * k * w) - (k * w) ** 2 * np.eye(3)
            load = np.array([0.0, 1.0 if k == 1 else 0.0, 0.0])
            motion = harmonics.amplitude(curve.response[i], k)
            residual = stiffness @ motion + harmonics.amplitude(forces.T, k) - load
            np.testing.assert_allclose(residual, 0, atol=1e-6, err_msg=f"w = {w}, harmonic {k}")


def test_energy_balance(curve):
    """Work of the force = area of both hysteresis loops + work of the dashpots, pi w sum k^2 q_k* C q_k."""
    w = 2 * np.pi * curve.frequency
    dashpots = np.zeros(len(curve))
    for k in range(1, 8):
        q = curve.harmonics.amplitude(curve.response, k)
        dashpots += np.pi * w * k**2 * np.real(np.einsum("ni,ij,nj->n", q.conj(), 0.02 * CHAIN, q))
    np.testing.assert_allclose(curve.friction_loss + dashpots, curve.work_in, atol=1e-4 * curve.work_in.max())
    assert curve.friction_loss.max() > 0.2 * curve.work_in.max()
