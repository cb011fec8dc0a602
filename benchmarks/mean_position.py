"""What the zero harmonic does to the in-phase mode: peak against force, with it and without.

Pesaresi et al. (2017), Fig. 12b: with harmonics 1-3 the mean position is held and the in-phase mode softens less.

    .venv/bin/python benchmarks/mean_position.py                              (small mesh)
    .venv/bin/python benchmarks/mean_position.py --run results/pesaresi2017   (the stages of a run)
"""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from updamp.effects.rig_model import RigModel
from updamp.fem.finite_element_model import finite_element_model
from updamp.fem.reduced_model import ReducedModel
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.hbm.continuation.curve import CurveRequest, whole_curve
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.harmonics import Harmonics
from updamp.model.build import rig_model
from updamp.model.rig_files import load_rig
from updamp.rig.rig import Rig
from updamp.workflow import store

RIG = Path(__file__).parents[1] / "rigs" / "pesaresi2017.toml"
ORDERS = ((0, 1, 2, 3), (1, 2, 3))


def coupled(rig: Rig, run: Path | None) -> RigModel:
    if run is None:
        reduced = finite_element_model(build_mesh(rig, "small"), rig).reduced
        return rig_model(reduced, static_contact(reduced, rig), rig)
    stages = run / "stages"
    reduced = store.read(stages / "finite_elements.h5", ReducedModel, part="reduced")
    return rig_model(reduced, store.read(stages / "static_contact.h5", StaticContact), rig)


def curve(model: RigModel, rig: Rig, mode: str, force: float) -> ResponseCurve:
    request = CurveRequest(mode, model.excited_by(force), rig.study.modes[mode].window, (tip(rig),))
    return whole_curve(model.system, request)


def tip(rig: Rig) -> str:
    return rig.response_point


def main(
    run: Annotated[Path | None, typer.Option(help="folder of a run, for its finite elements")] = None,
    mode: Annotated[str, typer.Option(help="of the rig file's study")] = "IP",
    largest: Annotated[float, typer.Option(help="largest force [N]")] = 17.0,
) -> None:
    """Print peak frequency and receptance with and without the zero harmonic."""
    rig = load_rig(RIG)
    model = coupled(rig, run)
    table = Table("mode", "force", *[f"harmonics {'-'.join(map(str, o))}" for o in ORDERS])
    for force in (f for f in rig.study.force_levels if f <= largest):
        cells = []
        for orders in ORDERS:
            traced = curve(replace(model, harmonics=Harmonics(orders)), rig, mode, force)
            frequency, receptance = traced.peak(tip(rig))
            cells.append(f"{frequency:.2f} Hz, {receptance * 1e3:.5f} mm/N {traced.stopped}")
        table.add_row(mode, f"{force:g} N", *cells)
    Console(width=160).print(table)


if __name__ == "__main__":
    typer.run(main)
