"""What the zero harmonic does to the resonances: frequency at the phase resonance against force, with it and without.

Pesaresi et al. (2017), Fig. 12b: with harmonics 1-3 the mean position is held and the in-phase mode softens less.

    .venv/bin/python benchmarks/mean_position.py            (small mesh; --mesh medium for 146 patches)
"""

from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from updamp.fem.finite_element_model import finite_element_model
from updamp.fem.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.resonance_conditions import PhaseResonance
from updamp.hbm.resonance_curve import ResonanceCurve, ResonanceRequest, trace_resonance
from updamp.hbm.rig_system import rig_system
from updamp.hbm.system import NonlinearSystem
from updamp.rig import load_rig

RIG = Path(__file__).parents[1] / "rigs" / "pesaresi2017.toml"
WINDOWS = {"OOP": (434.0, 452.0), "IP": (415.0, 432.0)}  # Hz, while stuck
TARGETS = {"OOP": -np.pi / 2, "IP": -np.pi / 2}


def resonance(system: NonlinearSystem, mode: str, forces: tuple[float, ...], blade: str) -> ResonanceCurve:
    """The resonance of a mode against force, at the tip of the excited blade."""
    request = ResonanceRequest(
        mode,
        f"blade_{blade}.excitation.x",
        f"blade_{blade}.tip.x",
        WINDOWS[mode],
        forces,
        PhaseResonance(TARGETS[mode]),
    )
    *_, curve = trace_resonance(system, request)
    return curve


def main(
    mesh: Annotated[str, typer.Option(help="mesh preset")] = "small",
    largest: Annotated[float, typer.Option(help="largest force [N]")] = 17.0,
) -> None:
    """Print resonance frequency and receptance with and without the zero harmonic."""
    rig = load_rig(RIG)
    reduced = finite_element_model(build_mesh(rig, mesh), rig).reduced
    system = rig_system(reduced, static_contact(reduced, rig), rig)
    forces = tuple(f for f in rig.study.force_levels if f <= largest)
    table = Table("mode", "harmonics", *[f"{f:g} N" for f in forces], "stopped")
    for mode in WINDOWS:
        for orders in ((0, 1, 2, 3), (1, 2, 3)):
            curve = resonance(system.with_harmonics(Harmonics(orders)), mode, forces, rig.excitation.blade)
            met = curve.at_forces()
            at = {float(f): i for i, f in enumerate(met.force)}
            cells = [
                f"{met.frequency[at[f]]:.2f} Hz, {abs(met.receptance[at[f]]) * 1e3:.4f} mm/N" if f in at else "-"
                for f in forces
            ]
            table.add_row(mode, "-".join(map(str, orders)), *cells, curve.stopped)
    Console(width=200).print(table)


if __name__ == "__main__":
    typer.run(main)
