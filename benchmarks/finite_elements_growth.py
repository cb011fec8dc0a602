"""How the finite elements' cost grows with the degrees of freedom, and what a change of one component costs.

    .venv/bin/python benchmarks/finite_elements_growth.py [small medium ...] [--picture FILE]

Each mesh in a process of its own with one thread; processor time. Prints a table with the powers of the growth.
"""

import argparse
from dataclasses import asdict, dataclass
from pathlib import Path
from time import process_time

import matplotlib.pyplot as plt
import numpy as np

from updamp.benchmarks.harmonic_balance.measure import in_a_process
from updamp.fem.finite_element_model import component_model, coupled_check, joined
from updamp.fem.rig_components import BLADE, DAMPER, RigComponents
from updamp.fem.springs import ContactStiffness
from updamp.geometry.build_mesh import build_mesh
from updamp.model.rig_files import load_rig
from updamp.parallel.resources import Meter

RIG = Path(__file__).parents[1] / "rigs" / "pesaresi2017.toml"
# Name -> preset and changes: between the presets, the same sections with other divisions of the width.
MESHES = {
    "small": ("small", {}),
    "half": ("medium", {"mesh.medium.width": 10}),
    "medium": ("medium", {}),
    "wide": ("medium", {"mesh.medium.width": 40}),
    "full": ("full", {}),
    "double": ("full", {"mesh.full.width": 80}),
}
USUAL = ("small", "half", "medium", "wide")


@dataclass(frozen=True)
class Cost:
    """Processor time [s] of each step; memory: largest resident [GB]. blade: assembly, factors, modes and residual"""

    unknowns: int
    mesh: float
    blade: float
    factors: float
    damper: float
    check: float
    memory: float


def cost(name: str) -> Cost:
    preset, changes = MESHES[name]
    rig = load_rig(RIG, dict(changes))
    clock = _Laps()
    with Meter() as meter:
        mesh = build_mesh(rig, preset)
        meshed = clock.lap()
        with RigComponents(mesh, rig) as parts:
            factorised = parts.factorised(BLADE)
            factors = clock.lap()
            blade = component_model(parts, BLADE)
            after = clock.lap()
            damper = component_model(parts, DAMPER)
            floating = clock.lap()
            contact = ContactStiffness(rig.contact.tangential_stiffness, rig.contact.normal_stiffness)
            coupled_check(parts, joined(blade, damper, mesh.contacts).reduced, contact)
            unknowns = factorised.component.matrices.n_dofs
        checked = clock.lap()
    return Cost(unknowns, meshed, factors + after, factors, floating, checked, meter.peak_memory / 1e9)


class _Laps:
    def __init__(self) -> None:
        self._last = process_time()

    def lap(self) -> float:
        before, self._last = self._last, process_time()
        return self._last - before


def powers(costs: list[Cost]) -> dict[str, float]:
    """Slope of each cost over the unknowns, both as logarithms, between the two largest meshes."""
    one, two = sorted(costs, key=lambda c: c.unknowns)[-2:]
    ratio = np.log(two.unknowns / one.unknowns)
    return {k: float(np.log(v / asdict(one)[k]) / ratio) for k, v in asdict(two).items() if k != "unknowns"}


def table(costs: list[Cost]) -> str:
    names = [name for name in asdict(costs[0]) if name != "unknowns"]
    lines = ["| unknowns of a blade | " + " | ".join(names) + " |", "|" + "---|" * (len(names) + 1)]
    lines += [f"| {c.unknowns:,} | " + " | ".join(f"{asdict(c)[n]:.3g}" for n in names) + " |" for c in costs]
    if len(costs) > 1:
        lines.append("| power | " + " | ".join(f"{powers(costs)[n]:.2f}" for n in names) + " |")
    return "\n".join(lines)


def draw(costs: list[Cost], path: Path) -> None:
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3.8), layout="constrained")
    at = [c.unknowns for c in costs]
    for name in ("mesh", "blade", "factors", "damper", "check"):
        left.loglog(at, [asdict(c)[name] for c in costs], "o-", label=name)
    left.set(xlabel="unknowns of a blade", ylabel="processor time, s")
    left.legend(frameon=False)
    right.loglog(at, [c.memory for c in costs], "o-")
    right.set(xlabel="unknowns of a blade", ylabel="memory, GB")
    for axes in (left, right):
        axes.grid(which="both", alpha=0.25)
    figure.savefig(path, dpi=160)
    plt.close(figure)


def main() -> None:
    reader = argparse.ArgumentParser(description=__doc__)
    reader.add_argument("meshes", nargs="*", default=list(USUAL), choices=[[], *MESHES], metavar="MESH")
    reader.add_argument("--picture", type=Path)
    stated = reader.parse_args()
    costs = []
    for name in stated.meshes:
        costs.append(in_a_process(1, cost, name))
        print(name, costs[-1], flush=True)
    print(table(costs))
    if stated.picture:
        draw(costs, stated.picture)


if __name__ == "__main__":
    main()
