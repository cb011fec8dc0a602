"""Is a curve the same after a change of round-off? Upwards, downwards, and with every mode shape and frequency
changed by a relative 1e-13 at random, at `small` size.

    .venv/bin/python benchmarks/reproducibility.py [--mode IP --force 17]

Printed: peak, resonance, jumps of a sweep up and down, and resonances by phase, with the largest deviation of each.
"""

import os

from updamp.parallel.resources import thread_limits

os.environ.update(thread_limits(1))

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from updamp.fem.finite_element_model import finite_element_model
from updamp.fem.reduced_model import ReducedComponent, ReducedModel
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.hbm.compilation_cache import keep_compiled
from updamp.hbm.continuation.curve import CurveRequest, whole_curve
from updamp.hbm.continuation.sweeps import swept
from updamp.hbm.resonance.quadrature import quadrature_resonances
from updamp.model.build import rig_model
from updamp.model.rig_files import load_rig
from updamp.rig.rig import Rig

RIG = Path(__file__).parents[1] / "rigs" / "pesaresi2017.toml"
CURVES = (("OOP", 3.84), ("OOP", 9.6), ("OOP", 17.0), ("IP", 3.84), ("IP", 9.6), ("IP", 17.0))
ROUND_OFF, SEEDS = 1e-13, (1, 2)


@dataclass(frozen=True)
class Reading:
    """What a reader takes from a curve. peak [m/N]; frequency [Hz]; up, down: jumps [Hz]; resonances [Hz]"""

    name: str
    complete: bool
    points: int
    peak: float
    frequency: float
    up: tuple[float, ...]
    down: tuple[float, ...]
    resonances: tuple[float, ...]


def small_model(rig: Rig) -> ReducedModel:
    return finite_element_model(build_mesh(rig, "small"), rig).reduced


def readings(
    rig: Rig, reduced: ReducedModel, mode: str, force: float, seeds: tuple[int, ...] = SEEDS
) -> Iterator[Reading]:
    """One for each way of tracing the curve."""
    ways = [("upwards", reduced, True), ("downwards", reduced, False)]
    ways += [(f"round-off, seed {seed}", with_round_off(reduced, seed), True) for seed in seeds]
    for name, model, upwards in ways:
        yield read(name, rig, model, mode, force, upwards)


def with_round_off(reduced: ReducedModel, seed: int) -> ReducedModel:
    """Mode shapes and frequencies changed by so much."""
    rng = np.random.default_rng(seed)

    def changed(values: np.ndarray) -> np.ndarray:
        return values * (1 + ROUND_OFF * rng.uniform(-1, 1, values.shape))

    def component(c: ReducedComponent) -> ReducedComponent:
        return replace(c, phi=changed(c.phi), omega=changed(c.omega))

    left, right, damper = (component(c) for c in reduced.components)
    return replace(reduced, blade_left=left, blade_right=right, damper=damper)


def read(name: str, rig: Rig, reduced: ReducedModel, mode: str, force: float, upwards: bool) -> Reading:
    model, tip = rig_model(reduced, static_contact(reduced, rig), rig), rig.response_point
    request = CurveRequest(mode, model.excited_by(force), rig.study.modes[mode].window, (tip,), upwards)
    curve = whole_curve(model.system, request)
    frequency, peak = curve.peak(tip)
    jumps = [tuple(swept(curve, way).jumps) if curve.complete else () for way in (True, False)]
    resonances = tuple(sorted(r.frequency for r in quadrature_resonances(curve, tip)))
    return Reading(name, curve.complete, len(curve), peak, frequency, jumps[0], jumps[1], resonances)


def main(
    mode: Annotated[str | None, typer.Option(help="only this mode")] = None,
    force: Annotated[float | None, typer.Option(help="only this force [N]")] = None,
) -> None:
    """Trace six curves of the reference rig four ways each and compare what is read from them."""
    keep_compiled()
    console, rig = Console(width=170), load_rig(RIG)
    reduced = small_model(rig)
    for curve in (c for c in CURVES if mode in (None, c[0]) and force in (None, c[1])):
        found = list(readings(rig, reduced, *curve))
        peaks, frequencies = ([getattr(r, name) for r in found] for name in ("peak", "frequency"))
        table = Table("way", "points", "peak mm/N", "at Hz", "jumps up Hz", "jumps down Hz", "resonances Hz", "")
        table.title = (
            f"{curve[0]} {curve[1]:g} N: peak within {100 * (max(peaks) / min(peaks) - 1):.2g} %, "
            f"resonance within {max(frequencies) - min(frequencies):.2g} Hz"
        )
        for r in found:
            lists = (", ".join(f"{f:.2f}" for f in values) for values in (r.up, r.down, r.resonances))
            end = "" if r.complete else "not complete"
            table.add_row(r.name, str(r.points), f"{1e3 * r.peak:.6f}", f"{r.frequency:.4f}", *lists, end)
        console.print(table)


if __name__ == "__main__":
    typer.run(main)
