"""All solvers solve the same systems and give the same modes; what they cannot do they say."""

import os
import subprocess
import sys

import numpy as np
import pytest
from scipy import sparse

from updamp.fem.assembly import assemble, clamp
from updamp.fem.component import component, factorised
from updamp.fem.interface import Interface
from updamp.fem.modes import normal_modes
from updamp.fem.quadratic_mesh import quadratic_mesh
from updamp.fem.rigid_body import rigid_body_fields
from updamp.fem.solvers import SOLVERS, SolverFailedError, SolverMissingError, amg, solver_named

NAMES = tuple(SOLVERS)


def available(name: str):
    solver = solver_named(name)
    try:
        solver(sparse.bsr_array(np.eye(3)), np.ones((3, 1)))
    except SolverMissingError as missing:
        pytest.skip(str(missing))
    return solver


@pytest.fixture(scope="module")
def cantilever(box, steel):
    mesh = quadratic_mesh(box((2, 8, 2), (0.02, 0.15, 0.03)))
    matrices = clamp(assemble(mesh, steel), np.unique(mesh.faces["root"]))
    nothing = Interface(sparse.csc_array((matrices.n_dofs, 0)), ())
    return component(mesh, matrices, nothing, free=False)


@pytest.fixture(scope="module")
def prepared(cantilever):
    matrices = cantilever.matrices
    return matrices.stiffness, rigid_body_fields(cantilever.mesh.nodes[matrices.free_nodes])


@pytest.mark.parametrize("name", NAMES)
def test_solves_one_and_many(prepared, name: str) -> None:
    factor = available(name)(*prepared)
    rhs = np.random.default_rng(5).standard_normal((prepared[0].shape[0], 3))
    exact = np.linalg.solve(prepared[0].toarray(), rhs)
    for given, expected in ((rhs, exact), (rhs[:, 1], exact[:, 1]), (rhs[:, ::2], exact[:, ::2])):
        found = factor.solve(given)
        assert found.shape == given.shape
        np.testing.assert_allclose(found, expected, atol=1e-7 * np.abs(expected).max())
    factor.close()
    factor.close()  # twice does no harm
    with pytest.raises(SolverFailedError, match="was closed"):
        factor.solve(rhs)


@pytest.mark.parametrize("name", NAMES)
def test_gives_the_modes_of_a_dense_solver(cantilever, name: str) -> None:
    from scipy.linalg import eigh

    matrices = cantilever.matrices
    values = eigh(matrices.stiffness.toarray(), matrices.mass.toarray(), eigvals_only=True, subset_by_index=[0, 7])
    with factorised(cantilever, available(name)) as part:
        modes = normal_modes(part, 8)
    np.testing.assert_allclose(modes.omega, np.sqrt(values), rtol=1e-9)
    assert modes.max_relative_residual < 1e-6


def test_indefinite_matrix_is_refused(prepared) -> None:
    stiffness, near_null_space = prepared
    for name in ("pardiso", "cholmod"):
        try:
            solver = solver_named(name)
            with pytest.raises(SolverFailedError, match="check that the component is clamped"):
                solver(-stiffness, near_null_space)
        except SolverMissingError:
            assert name == "cholmod"


def test_amg_says_when_it_does_not_converge(prepared, monkeypatch) -> None:
    monkeypatch.setattr(sys.modules[amg.__module__], "MAX_ITERATIONS", 2)
    factor = amg(*prepared)
    with pytest.raises(SolverFailedError, match=r"relative residual of .* in 2 steps.*use a direct solver"):
        factor.solve(np.ones(prepared[0].shape[0]))


@pytest.mark.parametrize(("name", "module"), [("pardiso", "pypardiso"), ("cholmod", "sksparse.cholmod")])
def test_missing_solver_names_how_to_get_it(prepared, monkeypatch, name: str, module: str) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(SolverMissingError, match=r"is not available.*pip install"):
        solver_named(name)(*prepared)


def test_unknown_solver_is_refused() -> None:
    with pytest.raises(ValueError, match=r"reduction.solver = 'magic' is unknown; choose one of pardiso, cholmod, amg"):
        solver_named("magic")


REPEATED = """
import hashlib, sys
{first}
import numpy as np
from scipy import sparse
from updamp.fem import solvers
sys.modules["updamp.fem.solvers.pardiso"]._ENOUGH_FOR_THREADS = 0
line = sparse.diags_array([-np.ones(19), 2.5 * np.ones(20), -np.ones(19)], offsets=[-1, 0, 1])
one = sparse.eye_array(20)
grid = sparse.kron(sparse.kron(line, one), one) + sparse.kron(one, sparse.kron(line, one) + sparse.kron(one, line))
matrix = sparse.bsr_array(sparse.kron(grid, 0.2 * np.ones((3, 3)) + np.eye(3)).tobsr((3, 3)))
rhs = np.random.default_rng(3).standard_normal((24_000, 4))
for i in range(2):
    somewhere_else = np.zeros(1000 + 77 * i)
    factor = solvers.solver_named("pardiso")(matrix, rhs)
    print(*(hashlib.sha256(factor.solve(one).tobytes()).hexdigest()[:12] for one in (rhs[:, 0], rhs)))
    factor.close()
"""


def digests(first: str, threads: str) -> list[list[str]]:
    """Of the solutions for one and for four right-hand sides, twice, in a process of its own. first: its first line"""
    run = subprocess.run(
        [sys.executable, "-c", REPEATED.format(first=first)],
        env={**os.environ, "MKL_NUM_THREADS": threads},
        capture_output=True,
        text=True,
        check=True,
    )
    return [line.split() for line in run.stdout.splitlines()]


def test_last_digits_do_not_depend_on_chance_or_on_what_else_is_loaded() -> None:
    """gmsh brings the OpenMP library of GNU, which MKL uses where it finds it."""
    available("pardiso")
    alone, with_gmsh, one_thread = digests("", "2"), digests("import gmsh", "2"), digests("", "1")
    assert alone[0] == alone[1] == with_gmsh[0] == with_gmsh[1]
    assert one_thread[0] == one_thread[1]
    assert one_thread[0][0] == alone[0][0]  # for one right-hand side, whatever the number of threads
