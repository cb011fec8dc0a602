"""Derivatives with respect to 20 parameters, as a share of the solve of the point: processor time, one thread."""

from updamp.parallel.resources import one_thread

one_thread()  # before numpy is loaded

import json
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated

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


@dataclass(frozen=True)
class SensitivityCost:
    """Of 20 parameters at the point of most slip. seconds, point_s, median_point_s: processor time of the derivatives,
    of that point and of the branch's median point"""

    problem: str
    active_rows: int
    solver: str
    seconds: float
    point_s: float
    median_point_s: float

    @property
    def share_of_point(self) -> float:
        return self.seconds / self.point_s


def measured(name: str, system: NonlinearSystem) -> SensitivityCost:
    excitation = Excitation(system.free.row("excitation"), FORCE)
    point, solve_s, median_s = busiest(system, excitation)
    held = FixedPhase.at(point.solution.equation, excitation, system.free.row("tip"))
    parameters = twenty(system)
    seconds = median_time(point.solution, lambda s: sensitivities(s, excitation, parameters, held, ("tip",)))
    jacobian = point.solution.jacobian
    assert jacobian is not None, "a converged solution carries its Jacobian"
    return SensitivityCost(name, jacobian.n_active, type(jacobian.forces).__name__, seconds, solve_s, median_s)


def costs() -> Iterator[SensitivityCost]:
    for name, title in (("c_model_20.npz", "20 contacts"), ("c_model_146.npz", "146 contacts")):
        system = load(name)
        if system is None:
            print(f"{title}: {name} is not beside the checkout")
            continue
        yield measured(title, system)
        yield measured(f"{title}, residual flexibility (synthetic)", with_residual(system))


def main(out: Annotated[Path | None, typer.Option(help="JSON file to write, which bench.py takes up")] = None) -> None:
    """Measure and print: of the problems of other codes that are beside the checkout."""
    print(f"{len(twenty(load('c_model_20.npz')))} parameters at fixed phase, at the point of most slip, {FORCE:g} N")
    found = []
    for cost in costs():
        found.append(cost)
        print(
            f"{cost.problem:42s} {cost.active_rows:4d} active rows, {cost.solver:13s} "
            f"{1e3 * cost.seconds:7.1f} ms; the point {1e3 * cost.point_s:7.1f} ms ({cost.share_of_point:.1%}), "
            f"median point {1e3 * cost.median_point_s:.1f} ms ({cost.seconds / cost.median_point_s:.1%})"
        )
    if out is not None:
        shares = {cost.problem: cost.share_of_point for cost in found}
        out.write_text(json.dumps({"share_of_point": shares, "measured": [asdict(c) for c in found]}, indent=1) + "\n")


if __name__ == "__main__":
    typer.run(main)
