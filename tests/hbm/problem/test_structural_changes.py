"""Masses and dashpots on a model with few modes and residual flexibility are exact, and vanish with their size.

A clamped steel beam of finite elements. A model with truncated modes is no better than its static residual, so it is
compared with H - H V (Z^-1 + V^T H V)^-1 V^T H, H its own receptance and Z the attachments' dynamic stiffness; one that
keeps more modes with the beam itself.
"""

from dataclasses import replace

import numpy as np
import pytest

from updamp.hbm.problem.linear_model import LinearModel, add_springs, from_matrices
from updamp.hbm.problem.structural_changes import Attachment, attach

LENGTH, WIDTH, HEIGHT, YOUNG, DENSITY, ELEMENTS = 0.3, 0.02, 0.01, 2e11, 7800.0, 30
SPRINGS = np.array([1e5, 1e7])  # N/m, on the relative rows
LOW, TIP = {"low": 1.0}, {"tip": 1.0}


def beam() -> tuple[np.ndarray, np.ndarray]:
    """M and K (60, 60) of Euler's beam with cubic shape functions, clamped: deflection and slope of each node"""
    length, inertia, area = LENGTH / ELEMENTS, WIDTH * HEIGHT**3 / 12, WIDTH * HEIGHT
    scale = np.array([1.0, length, 1.0, length])
    k = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]]) * np.outer(scale, scale)
    m = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) * np.outer(scale, scale)
    K, M = np.zeros((2 * ELEMENTS + 2,) * 2), np.zeros((2 * ELEMENTS + 2,) * 2)
    for node in range(0, 2 * ELEMENTS, 2):
        K[node : node + 4, node : node + 4] += YOUNG * inertia / length**3 * k
        M[node : node + 4, node : node + 4] += DENSITY * area * length / 420 * m
    return M[2:, 2:], K[2:, 2:]


def row(node: int) -> np.ndarray:
    return np.eye(2 * ELEMENTS)[2 * node]


RELATIVE = np.stack([row(20), row(10) - row(5)])
POINTS = {"low": row(3), "middle": row(14), "tip": row(29)}
ROWS = np.vstack([RELATIVE, *POINTS.values()])


def truncated(kept: int) -> LinearModel:
    """`kept` modes and the exact static flexibility of the others; loss factor 0.1 %

    The flexibility is made symmetric: as `solve` leaves it, by round-off with a condition of 2e8, it is so to 4e-11
    only on some processors, and what attaches masses takes it as symmetric.
    """
    M, K = beam()
    full = from_matrices(M, np.zeros_like(M), K, RELATIVE, POINTS)
    omega_squared, phi = full.omega_squared[:kept], full.phi[:, :kept]
    flexibility = ROWS @ np.linalg.solve(K, ROWS.T)
    return replace(
        full,
        omega_squared=omega_squared,
        phi=phi,
        residual=(flexibility + flexibility.T) / 2 - phi / omega_squared @ phi.T,
        hysteretic=1e-3 * np.diag(omega_squared),
        viscous=np.zeros((kept, kept)),
    )


def woodbury(model: LinearModel, attachments: list[Attachment], w: float) -> np.ndarray:
    H, V = model.receptance(w), np.stack([a.direction(model) for a in attachments], axis=1)
    Z = np.diag([a.stiffness + 1j * w * a.dashpot - w**2 * a.mass for a in attachments])
    HV = H @ V
    return H - HV @ np.linalg.solve(np.eye(len(Z)) + Z @ (V.T @ HV), Z @ HV.T)


def difference(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.abs(one / other - 1).max())


@pytest.mark.parametrize(
    "attachments",
    [
        [Attachment("mass", LOW, mass=0.3)],
        [Attachment("dashpot", LOW, dashpot=100.0)],
        [Attachment("all", LOW, stiffness=1e6, dashpot=100.0, mass=0.3)],
        [Attachment("mass", LOW, mass=0.3), Attachment("dashpot", LOW, dashpot=50.0)],
        [Attachment("mass", LOW, mass=0.3), Attachment("between", {"tip": 1.0, "middle": -1.0}, 1e5, 50.0, 0.02)],
        [Attachment("mass", LOW, mass=0.3), Attachment("little", TIP, mass=1e-8), Attachment("d", TIP, dashpot=1e-3)],
    ],
    ids=lambda attachments: ", ".join(a.name for a in attachments),
)
@pytest.mark.parametrize("times", [0.98, 3.0])
def test_exact_whatever_the_truncation_and_so_with_springs_after(attachments, times):
    model = truncated(5)
    w = times * np.sqrt(model.omega_squared[0])
    attached = attach(model, attachments)
    wanted = woodbury(model, attachments, w)
    assert difference(model.receptance(w), wanted) > 1e-3
    assert difference(attached.receptance(w), wanted) < 1e-10
    stuck = woodbury(add_springs(model, np.eye(5, 2), SPRINGS), attachments, w)
    assert difference(add_springs(attached, np.eye(5, 2), SPRINGS).receptance(w), stuck) < 1e-9


def test_one_mode_more_for_each_displacement_that_something_acts_on():
    model = truncated(5)
    low = [Attachment("mass", LOW, mass=0.3), Attachment("dashpot", LOW, dashpot=50.0)]
    assert len(attach(model, low).omega_squared) == 6
    assert len(attach(model, [*low, Attachment("tip", TIP, mass=0.1)]).omega_squared) == 7
    assert len(attach(model, [Attachment("spring", LOW, stiffness=1e6)]).omega_squared) == 5
    assert len(attach(replace(model, residual=np.zeros((5, 5))), low).omega_squared) == 5
    left = attach(model, low).residual[model.row("low")]
    np.testing.assert_allclose(left, 0, atol=1e-9 * model.residual.max())


def test_frequencies_near_the_clamp_are_those_of_the_full_beam():
    """A mass where modes hardly move: through five modes alone it would be felt too little."""
    M, K = beam()
    M_attached = M + 5.0 * np.outer(POINTS["low"], POINTS["low"])
    full = from_matrices(M_attached, np.zeros_like(M), K, RELATIVE, POINTS).frequencies[:2]
    bare = from_matrices(M, np.zeros_like(M), K, RELATIVE, POINTS).frequencies[:2]
    shift = attach(truncated(5), [Attachment("mass", LOW, mass=5.0)]).frequencies[:2] - bare
    through_modes = attach(
        replace(truncated(5), residual=np.zeros((5, 5))), [Attachment("mass", LOW, mass=5.0)]
    ).frequencies[:2] - bare  # fmt: skip
    np.testing.assert_allclose(shift, full - bare, rtol=3e-3)
    assert np.abs(through_modes / (full - bare) - 1).max() > 0.03


@pytest.mark.parametrize("quantity", ["mass", "dashpot"])
@pytest.mark.parametrize("springs", [False, True])
def test_no_jump_at_nothing_and_derivatives_from_small_steps(quantity, springs):
    """The signature of an effect comes from a step of 1e-5 of its typical size, at resonance."""
    model, typical = truncated(5), {"mass": 0.05, "dashpot": 20.0}[quantity]

    def response(value: float, harmonic: int = 1) -> np.ndarray:
        attached = attach(model, [Attachment("a", LOW, **{quantity: value})])
        whole = add_springs(attached, np.eye(5, 2), SPRINGS) if springs else attached
        return np.log(whole.receptance(harmonic * w))

    w = 2 * np.pi * 0.9999 * (add_springs(model, np.eye(5, 2), SPRINGS) if springs else model).frequencies[0]
    for harmonic in (1, 3):
        there = response(1e-14 * typical, harmonic)
        np.testing.assert_allclose(there, response(0.0, harmonic), rtol=0, atol=2e-10)
    slopes = [(response(step) - response(0.0)) / step for step in (1e-5 * typical, 1e-4 * typical)]
    np.testing.assert_allclose(slopes[0], slopes[1], atol=1e-3 * np.abs(slopes[1]).max())


def test_a_negative_mass_is_refused():
    with pytest.raises(ValueError, match=r"attachment a has a mass of -0\.1 kg"):
        Attachment("a", LOW, mass=-0.1)
