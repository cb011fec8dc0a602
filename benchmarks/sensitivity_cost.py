"""Derivatives with respect to 20 parameters, as a share of the solve of the point: processor time, one thread."""

from updamp.parallel.resources import one_thread

one_thread()  # before numpy is loaded

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import typer

from updamp.hbm.analysis.held_quantities import FixedPhase
from updamp.hbm.analysis.sensitivity import sensitivities
from updamp.hbm.analysis.sensitivity_parameters import (
    ContactParameter,
    ExcitationForce,
    Parameter,
    hysteretic_scale,
    mode_frequency,
    scaled,
    viscous_scale,
)
from updamp.hbm.analysis.sensitivity_patches import Dashpot, Mass, Spring, patch_direction
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.continuation import continue_branch
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.newton.jacobian import factorise
from updamp.hbm.newton.newton import Solution
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import LinearModel, from_matrices
from updamp.hbm.problem.system import Excitation, NonlinearSystem

ROOT = Path(__file__).parent.parent
FOLDERS = (ROOT / "tests" / "hbm" / "reference", ROOT.parent / "shared" / "reference" / "hbm")
WINDOW, FORCE, REPEATS = (226.0, 250.0), 40.0, 7


def load(name: str) -> NonlinearSystem | None:
    """None where the solved problem is not beside the checkout."""
    path = next((folder / name for folder in FOLDERS if (folder / name).exists()), None)
    if path is None:
        return None
    d = np.load(path)
    n = len(d["N0"])
    linear = from_matrices(d["M"], d["C"], d["K"], d["Q"], {"excitation": d["F"], "tip": d["out"]})
    every = np.ones(n)
    parameters = FrictionParameters(
        d["mu"] * every, d["kt"] * every, d["kn"] * every, d["N0"], np.zeros((n, 2)), 0 * every
    )
    group = ElementGroup(JenkinsBox(2), parameters, np.arange(3 * n).reshape(n, 3))
    return NonlinearSystem(linear, (group,), Harmonics((0, 1, 2, 3)), 128)


def with_residual(system: NonlinearSystem) -> NonlinearSystem:
    """A synthetic residual flexibility with the spectrum measured on a rig: 19 to 1.4 over the contact stiffness."""
    n = system.free.n_rows
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(n, n)))[0]
    flexibility = np.geomspace(19, 1.4, n) / system.reference_stiffness.max()
    return replace(system, free=replace(system.free, residual=(turn * flexibility) @ turn.T))


def twenty(system: NonlinearSystem) -> list[Parameter]:
    free: LinearModel = system.free
    n0 = np.asarray(system.groups[0].parameters.n0)
    quarter = np.arange(len(n0)) * 4 // len(n0)
    tip, excited = patch_direction(free, {"tip": 1.0}), patch_direction(free, {"excitation": 1.0})
    return [
        *(scaled(system, entry) for entry in ("mu", "kt", "kn", "n0")),
        *(ContactParameter(system, "n0", n0 * (quarter == q)) for q in range(4)),
        *(mode_frequency(free, mode) for mode in range(4)),
        hysteretic_scale(free),
        viscous_scale(free),
        ExcitationForce(),
        *(kind(d) for kind in (Spring, Mass) for d in (tip, excited)),
        Dashpot(tip),
    ]


def busiest(system: NonlinearSystem, excitation: Excitation) -> tuple[BranchPoint, float, float]:
    """The point of the branch with most active rows, the processor seconds it took, and the median over the branch."""
    list(continue_branch(system, excitation, (WINDOW[0], WINDOW[0] + 0.01)))  # compiles
    points, seconds, start = [], [], time.process_time()
    for point in continue_branch(system, excitation, WINDOW):
        seconds.append(time.process_time() - start)
        points.append(point)
        start = time.process_time()
    most = int(np.argmax([p.solution.jacobian.n_active for p in points if p.solution.jacobian is not None]))
    return points[most], seconds[most], float(np.median(seconds))


def median_time(solution: Solution, work: Callable[[Solution], object]) -> float:
    """Of repeats that each find the point as Newton left it: what a Jacobian keeps of an earlier call is forgotten."""
    jacobian = solution.jacobian
    assert jacobian is not None, "a converged solution carries its Jacobian"
    work(solution)
    seconds = []
    for _ in range(REPEATS):
        fresh = replace(solution, jacobian=factorise(jacobian.receptance, jacobian.departure))
        start = time.process_time()
        work(fresh)
        seconds.append(time.process_time() - start)
    return float(np.median(seconds))


def report(name: str, system: NonlinearSystem) -> None:
    excitation = Excitation(system.free.row("excitation"), FORCE)
    point, solve_s, median_s = busiest(system, excitation)
    held = FixedPhase.at(point.solution.equation, excitation, system.free.row("tip"))
    parameters = twenty(system)
    seconds = median_time(point.solution, lambda s: sensitivities(s, excitation, parameters, held, ("tip",)))
    jacobian = point.solution.jacobian
    assert jacobian is not None, "a converged solution carries its Jacobian"
    print(
        f"{name:42s} {jacobian.n_active:4d} active rows, {type(jacobian.forces).__name__:13s} "
        f"{1e3 * seconds:7.1f} ms; the point {1e3 * solve_s:7.1f} ms ({100 * seconds / solve_s:.1f} %), "
        f"median point {1e3 * median_s:.1f} ms ({100 * seconds / median_s:.1f} %)"
    )


def main() -> None:
    """Measure and print: of the problems of other codes that are beside the checkout."""
    print(f"{len(twenty(load('c_model_20.npz')))} parameters at fixed phase, at the point of most slip, {FORCE:g} N")
    for name, title in (("c_model_20.npz", "20 contacts"), ("c_model_146.npz", "146 contacts")):
        system = load(name)
        if system is None:
            print(f"{title}: {name} is not beside the checkout")
            continue
        report(title, system)
        report(f"{title}, residual flexibility (synthetic)", with_residual(system))


if __name__ == "__main__":
    typer.run(main)
