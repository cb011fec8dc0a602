"""Harmonic balance of the rig (small mesh, residual flexibility) against marching in time: several points, both modes.

    .venv/bin/python benchmarks/time_integration/against_time.py

Structural damping is replaced by viscous damping equal to it at the middle of the window, in both. Each point is
compared on the plane across the branch there; difference: harmonic balance less marching in time.
"""

from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from updamp.benchmarks.time_integration.rig_against_time import FINER, MarchedCase, Problem
from updamp.fem.finite_element_model import finite_element_model
from updamp.geometry.build_mesh import build_mesh
from updamp.hbm.analysis.settings import Setting
from updamp.hbm.continuation.branch import BranchPoint
from updamp.model.rig_files import load_rig

ROOT = Path(__file__).parents[2]
RIG = ROOT / "rigs" / "pesaresi2017.toml"
MANY = Setting(tuple(range(16)), 512, 3)
CASES = (
    (MarchedCase("OOP", 10.0, (440.0, 452.0), 0.01), 0.6),
    (MarchedCase("OOP", 30.0, (440.0, 449.0), 0.01), 0.1),
    (MarchedCase("OOP", 60.0, (437.0, 450.0), 0.01), 0.6),
    (MarchedCase("IP", 10.0, (420.0, 434.0), 0.01), 0.6),
    (MarchedCase("IP", 15.0, (415.0, 434.0), 0.01), 0.1),
    (MarchedCase("IP", 25.0, (380.0, 436.0), 0.01), 0.6),
    (MarchedCase("OOP", 9.6, (440.0, 450.0)), 0.6),
    (MarchedCase("OOP", 17.0, (438.0, 450.0)), 0.6),
)


def chosen(points: list[BranchPoint], size: np.ndarray, shares: tuple[float, ...] = (0.6, 0.85)) -> list[BranchPoint]:
    """The peak, and the points nearest to these shares of it, one on either side."""
    top = int(size.argmax())
    below = int(np.abs(size[: top + 1] - shares[0] * size[top]).argmin())
    beyond = top + int(np.abs(size[top:] - shares[1] * size[top]).argmin())
    return [points[i] for i in sorted({below, top, beyond})]


def main(steps: Annotated[int, typer.Option(help="a period")] = 1024) -> None:
    """Print the differences, harmonics 0-3, 0-7 and 0-15."""
    reduced = finite_element_model(build_mesh(load_rig(RIG), "small"), load_rig(RIG)).reduced
    table = Table("curve", "point", "stuck / slip / open", "0-3", "0-7", "0-15", "0-3 to 0-7", "largest multiplier")
    console = Console(width=190)
    for case, friction in CASES:
        problem = Problem.of(reduced, load_rig(RIG, {"contact.friction_coefficient": friction}), case)
        branch = problem.branch()
        size = np.array([abs(problem.amplitude(point)) for point in branch])
        name = f"{case.mode} {case.force:g} N, mu {friction:g}, loss {100 * problem.loss:.3g} %"
        for point in chosen(branch, size):
            states = " / ".join(str(count) for count in problem.states(point)[:3])
            where = f"{point.frequency:.2f} Hz, {abs(problem.amplitude(point)) / size.max():.0%}"
            table.add_row(name, where, states, *_cells(problem, point, steps))
    console.print(table)


def _cells(problem: Problem, point: BranchPoint, steps: int) -> list[str]:
    finer = problem.finer(point, FINER)
    many = problem.finer(finer, MANY) if finer else None
    try:
        marched = problem.march(point, many or finer, steps)
    except AssertionError as error:
        return [str(error)]
    cells = []
    for solution in (point, finer, many):
        d = problem.difference(solution, marched) if solution else None
        cells.append(f"{d.percent:+.3f} %, {d.hertz:+.4f} Hz" if d else "not solved")
    if finer:
        share = abs(problem.amplitude(point)) / abs(problem.amplitude(finer)) - 1
        cells.append(f"{100 * share:+.3f} %, {point.frequency - finer.frequency:+.4f} Hz")
    else:
        cells.append("not solved")
    return [*cells, f"{abs(marched.multipliers[0]):.4f}"]


if __name__ == "__main__":
    typer.run(main)
