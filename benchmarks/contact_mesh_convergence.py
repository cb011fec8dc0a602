"""Do resonance and peak depend on the number of contact elements, where contacts open and where they do not?

    .venv/bin/python benchmarks/contact_mesh_convergence.py                      (36 to 292 elements on `medium`)
    .venv/bin/python benchmarks/contact_mesh_convergence.py --mesh small --elements 36 --elements 72/4  (in four strips)

The same finite elements, the contact faces divided into more and more elements, and the curves of two modes at a low
force and at those where contacts slip and open. Elements are counted over both faces. Printed: peak, resonance and how
far both are from the finest ones; written: contact_mesh_convergence.json in the folder `--out`, after every curve.
"""

import os

from updamp.parallel.resources import thread_limits

os.environ.update(thread_limits(1))

import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from updamp.fem.finite_element_model import finite_element_model
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.hbm.compilation_cache import keep_compiled
from updamp.hbm.continuation.curve import CurveRequest, whole_curve
from updamp.model.build import RigModel, rig_model
from updamp.model.rig_files import load_rig
from updamp.rig.rig import Rig

ROOT = Path(__file__).parents[1]
RIG = ROOT / "rigs" / "pesaresi2017.toml"
ELEMENTS = ["36", "72", "146", "292"]
CURVES = (("OOP", 0.02), ("OOP", 17.0), ("IP", 0.02), ("IP", 3.84), ("IP", 9.6), ("IP", 17.0))


@dataclass(frozen=True)
class MeshPoint:
    """One curve. elements: of both faces, with the strips of one where these are stated, such as "72/4"
    peak [mm/N], resonance [Hz]; seconds of processor time"""

    elements: str
    mode: str
    force: float
    complete: bool
    points: int
    peak: float
    resonance: float
    seconds: float


def divided(rig: Rig, mesh: str, elements: str) -> RigModel:
    """The rig's model with its faces divided into so many contact elements. elements: as in `MeshPoint`"""
    number, _, strips = elements.partition("/")
    contacts = {"contact_elements": int(number), "contact_strips": int(strips) if strips else None}
    divisions = rig.mesh[mesh].model_copy(update=contacts)
    rig = rig.model_copy(update={"mesh": {mesh: divisions}})
    reduced = finite_element_model(build_mesh(rig, mesh), rig).reduced
    return rig_model(reduced, static_contact(reduced, rig), rig)


def converging(rig: Rig, mesh: str, elements: Sequence[str]) -> Iterator[MeshPoint]:
    tip = rig.response_point
    for count in elements:
        model = divided(rig, mesh, count)
        for mode, force in CURVES:
            started = time.process_time()
            request = CurveRequest(mode, model.excited_by(force), rig.study.modes[mode].window, (tip,))
            curve = whole_curve(model.system, request)
            frequency, peak = curve.peak(tip)
            seconds = round(time.process_time() - started, 1)
            yield MeshPoint(count, mode, force, curve.complete, len(curve), 1e3 * peak, frequency, seconds)


def show(console: Console, points: Sequence[MeshPoint]) -> None:
    for mode, force in CURVES:
        same = [point for point in points if (point.mode, point.force) == (mode, force)]
        if not same:
            continue
        finest = same[-1]
        table = Table("elements", "points", "peak mm/N", "at Hz", "peak off", "resonance off", "time s", "")
        table.title = f"{mode} {force:g} N"
        for point in same:
            off = f"{100 * (point.peak / finest.peak - 1):+.2f} %", f"{point.resonance - finest.resonance:+.3f} Hz"
            numbers = f"{point.points}", f"{point.peak:.6f}", f"{point.resonance:.3f}"
            table.add_row(f"{point.elements}", *numbers, *off, f"{point.seconds}", "" if point.complete else "gap")
        console.print(table)


def main(
    mesh: Annotated[str, typer.Option(help="preset of the rig file for the finite elements")] = "medium",
    elements: Annotated[list[str] | None, typer.Option(help="72/4: 72 in four strips; 36 72 146 292")] = None,
    out: Annotated[Path, typer.Option(help="folder of the results")] = ROOT / "results",
) -> None:
    """Trace the curves for each number of contact elements."""
    keep_compiled()
    console, points = Console(width=140), []
    out.mkdir(parents=True, exist_ok=True)
    for point in converging(load_rig(RIG), mesh, elements or ELEMENTS):
        points.append(point)
        (out / "contact_mesh_convergence.json").write_text(json.dumps([asdict(p) for p in points], indent=2) + "\n")
        console.print(
            f"{point.elements} elements, {point.mode} {point.force:g} N: {point.peak:.6f} mm/N", soft_wrap=True
        )
    show(console, points)


if __name__ == "__main__":
    typer.run(main)
