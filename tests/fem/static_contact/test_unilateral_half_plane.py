"""The contact solver against closed solutions on an elastic half-plane (Flamant; strips of uniform traction)."""

import numpy as np
import pytest

from updamp.fem.static_contact.contact_problem import ContactProblem, ContactStatus, StaticContactState
from updamp.fem.static_contact.unilateral_contact import solve_unilateral_contact

E, NU, P, RADIUS, HALF = 200e9, 0.3, 1e5, 0.1, 1.0e-3  # P [N/m]; HALF: half the width covered by strips [m]
COMPLIANCE = 2 * (1 - NU**2) / E  # 1 / E*, of two equal half-planes


def strip_average(offset: np.ndarray, width: float) -> np.ndarray:
    """Average of ln|x - x'| over two strips of this width and distance, exact (Johnson 1985, section 2.4)."""

    def twice_integrated(x):
        size = np.maximum(np.abs(x), 1e-300)
        return 0.5 * x**2 * np.log(size) - 0.75 * x**2

    return (
        twice_integrated(offset + width) - 2 * twice_integrated(offset) + twice_integrated(offset - width)
    ) / width**2


def half_planes(strips: int, half: float, gap_of, mu: float, rocks: bool = False) -> tuple[np.ndarray, ContactProblem]:
    """Two equal half-planes: normal and tangential influence are equal and do not couple; t2 is antiplane."""
    width = 2 * half / strips
    x = -half + width * (np.arange(strips) + 0.5)
    kernel = -2 * COMPLIANCE / np.pi * (strip_average(x[:, None] - x[None, :], width) - np.log(100 * half))
    C = np.zeros((3 * strips, 3 * strips))
    C[0::3, 0::3] = C[2::3, 2::3] = kernel
    C[1::3, 1::3] = kernel / (1 - NU)
    R = np.zeros((3 * strips, 3 + rocks))
    R[0::3, 0] = R[1::3, 1] = R[2::3, 2] = 1.0
    if rocks:
        R[2::3, 3] = x
    return x, ContactProblem(C, R, gap_of(x, width), np.full(strips, mu))


def parabola(x: np.ndarray, width: float) -> np.ndarray:
    return (x**2 + width**2 / 12) / (2 * RADIUS)


def solved(problem: ContactProblem, loads) -> tuple[StaticContactState, ...]:
    solution = solve_unilateral_contact(problem, np.asarray(loads, dtype=float))
    assert solution.status is ContactStatus.CONVERGED, solution.status
    assert solution.residuals.max() < 1e-10
    return solution.value


def order(errors: list[float]) -> float:
    """Slope of log error against log strips; each refinement doubles their number."""
    return -float(np.polyfit(np.arange(len(errors)), np.log2(errors), 1)[0])


HERTZ_HALF_WIDTH = np.sqrt(4 * P * RADIUS * COMPLIANCE / np.pi)


def second_moment_width(x: np.ndarray, force: np.ndarray, width: float) -> float:
    """Half-width of the semi-ellipse with this second moment: its variance is a^2 / 4."""
    return 2 * np.sqrt(np.sum(force * (x**2 + width**2 / 12)) / force.sum())


def test_cylinder_meets_hertz_and_converges() -> None:
    peak = 2 * P / (np.pi * HERTZ_HALF_WIDTH)
    width_errors, profile_errors, extents = [], [], []
    for strips in (40, 80, 160, 320):
        x, problem = half_planes(strips, HALF, parabola, 0.0)
        width = x[1] - x[0]
        (state,) = solved(problem, [[0, 0, P]])
        pressure = state.force[:, 2] / width
        theory = peak * np.sqrt(np.maximum(0, 1 - (x / HERTZ_HALF_WIDTH) ** 2))
        width_errors.append(abs(second_moment_width(x, state.force[:, 2], width) / HERTZ_HALF_WIDTH - 1))
        profile_errors.append(np.abs(pressure - theory).mean() / theory.mean())
        extents.append(abs(state.closed.sum() * width / (2 * HERTZ_HALF_WIDTH) - 1) * HERTZ_HALF_WIDTH / width)
        assert pressure.max() == pytest.approx(peak, rel=0.06 * 40 / strips)
    assert width_errors[-1] < 1e-3
    assert order(width_errors) > 1.0
    assert profile_errors[-1] < 5e-3
    assert order(profile_errors) > 1.0
    assert max(extents) <= 1.0  # the edge of the contact falls into the right strip or its neighbour


def test_flat_punch_meets_its_singular_pressure_and_converges() -> None:
    """Equal strips see the singular edge with order 1/2, and the inner half with order 1."""
    errors, inner_errors = [], []
    for strips in (20, 40, 80, 160):
        x, problem = half_planes(strips, HALF, lambda x, _: np.zeros_like(x), 0.0)
        width = x[1] - x[0]
        (state,) = solved(problem, [[0, 0, P]])
        assert state.closed.all()
        edges = np.clip(np.stack([x - width / 2, x + width / 2]) / HALF, -1, 1)
        error = np.abs(state.force[:, 2] / P - np.diff(np.arcsin(edges), axis=0)[0] / np.pi)
        errors.append(error.sum())
        inner_errors.append(error[np.abs(x) < HALF / 2].sum())
    assert errors[-1] < 0.012
    assert 0.47 < order(errors) < 0.53
    assert inner_errors[-1] < 6e-4
    assert order(inner_errors) > 0.9


def ellipse_below(x: np.ndarray, half: float) -> np.ndarray:
    """Integral of sqrt(1 - (x / half)^2) from the middle, the traction being zero outside."""
    u = np.clip(x / half, -1, 1)
    return half / 2 * (u * np.sqrt(1 - u**2) + np.arcsin(u))


@pytest.mark.parametrize("ratio", [0.3, 0.5, 0.75])
def test_partial_slip_meets_cattaneo_and_mindlin(ratio: float) -> None:
    mu = 0.6
    stick = HERTZ_HALF_WIDTH * np.sqrt(1 - ratio)
    peak = 2 * P / (np.pi * HERTZ_HALF_WIDTH)

    def theory_below(x):
        inner = stick / HERTZ_HALF_WIDTH * ellipse_below(x, stick)
        return mu * peak * (ellipse_below(x, HERTZ_HALF_WIDTH) - inner)

    errors = []
    for strips in (30, 60, 120, 240):
        x, problem = half_planes(strips, HALF / 2, parabola, mu)
        width = x[1] - x[0]
        state = solved(problem, [[0, 0, P], [ratio / 2 * mu * P, 0, P], [ratio * mu * P, 0, P]])[-1]
        theory = theory_below(x + width / 2) - theory_below(x - width / 2)
        errors.append(np.abs(state.force[:, 0] - theory).sum() / (ratio * mu * P))
        stuck = state.closed & (state.slip[:, 0] == 0)
        assert abs(stuck.sum() * width / 2 - stick) <= width
        assert np.all(state.slip[state.closed & ~stuck, 0] == 1)
        assert np.all(state.force[~stuck, 0] == mu * state.force[~stuck, 2])
    assert errors[-1] < 0.004
    assert order(errors) > 1.0


def test_hertz_pressure_is_independent_of_friction_and_reversal_leaves_a_locked_traction() -> None:
    """Loading to Q and back to zero: the residual traction of Mindlin and Deresiewicz (1953)."""
    mu, ratio = 0.6, 0.5
    x, problem = half_planes(240, HALF / 2, parabola, mu)
    width = x[1] - x[0]
    loading = [[part * ratio * mu * P, 0, P] for part in (0, 0.5, 1, 0.5, 0)]
    states = solved(problem, loading)
    stick, back = (HERTZ_HALF_WIDTH * np.sqrt(1 - part) for part in (ratio, ratio / 2))

    def theory_below(x):
        part = [a / HERTZ_HALF_WIDTH * ellipse_below(x, a) for a in (HERTZ_HALF_WIDTH, stick, back)]
        return 2 * mu * P / (np.pi * HERTZ_HALF_WIDTH) * (-part[0] + 2 * part[2] - part[1])

    theory = theory_below(x + width / 2) - theory_below(x - width / 2)
    assert np.abs(states[-1].force[:, 0] - theory).sum() < 0.01 * mu * P
    assert np.abs(states[-1].force[:, 0]).sum() > 0.1 * mu * P
    assert states[-1].force[:, 2] == pytest.approx(states[0].force[:, 2], abs=1e-12 * P)


def test_load_beyond_friction_has_no_equilibrium() -> None:
    _, problem = half_planes(40, HALF / 2, parabola, 0.6)
    solution = solve_unilateral_contact(problem, np.array([[0, 0, P], [0.61 * P, 0, P]]))
    assert solution.status is ContactStatus.NO_EQUILIBRIUM
    assert len(solution.value) == 1


def test_pulling_load_has_no_equilibrium() -> None:
    _, problem = half_planes(40, HALF / 2, parabola, 0.6)
    solution = solve_unilateral_contact(problem, np.array([[0, 0, -P]]))
    assert solution.status is ContactStatus.NO_EQUILIBRIUM
    assert solution.value == ()
    assert "direction of the load" in solution.status.value


def test_off_centre_punch_meets_its_tilt() -> None:
    """Load at x0 within a/2 of the middle: p = P (1 + 2 x0 x / a^2) / (pi sqrt(a^2 - x^2)) (Johnson 1985, 2.64)."""
    x, problem = half_planes(160, HALF, lambda x, _: np.zeros_like(x), 0.0, rocks=True)
    width, x0 = x[1] - x[0], 0.3 * HALF
    (state,) = solved(problem, [[0, 0, P, x0 * P]])
    edges = np.clip(np.stack([x - width / 2, x + width / 2]) / HALF, -1, 1)
    theory = np.diff(np.arcsin(edges) - 2 * x0 / HALF * np.sqrt(1 - edges**2), axis=0)[0] / np.pi
    inside = np.abs(x) < 0.8 * HALF
    assert state.force[inside, 2] / P == pytest.approx(theory[inside], rel=0.02)
    assert np.sum(state.force[:, 2] * x) == pytest.approx(x0 * P, rel=1e-10)


def test_far_off_centre_punch_lifts_one_side() -> None:
    x, problem = half_planes(80, HALF, lambda x, _: np.zeros_like(x), 0.0, rocks=True)
    (state,) = solved(problem, [[0, 0, P, 0.8 * HALF * P]])
    assert state.closed[x > 0.7 * HALF].all()
    assert not state.closed[x < 0].any()
    assert np.all(np.diff(state.opening[~state.closed]) < 0)
    assert np.sum(state.force[:, 2] * x) == pytest.approx(0.8 * HALF * P, rel=1e-10)


def test_complementarity_is_exact() -> None:
    _, problem = half_planes(80, HALF / 2, parabola, 0.6)
    for state in solved(problem, [[0, 0, P], [0.3 * P, 0, P]]):
        assert np.all(state.force[~state.closed] == 0)
        assert np.all(state.opening[state.closed] == 0)
        assert np.all(state.force[:, 2] * state.opening == 0)
        assert state.force[:, 2].min() >= 0
        assert state.opening.min() >= 0


def test_shapes_are_refused_by_name() -> None:
    C = np.eye(6)
    with pytest.raises(ValueError, match=r"rigid_modes has shape \(5, 1\), but 2 gaps ask for \(6, 1\)"):
        ContactProblem(C, np.zeros((5, 1)), np.zeros(2), np.zeros(2))
    with pytest.raises(ValueError, match=r"friction has the negative value -0.1"):
        ContactProblem(C, np.zeros((6, 1)), np.zeros(2), np.full(2, -0.1))
    problem = ContactProblem(C, np.ones((6, 1)), np.zeros(2), np.zeros(2))
    with pytest.raises(ValueError, match=r"loads \(1, 2\)"):
        solve_unilateral_contact(problem, np.zeros((1, 2)))
