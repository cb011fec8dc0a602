"""What a run leaves for people and other programs: ParaView meshes, CSV, pictures, summary.json."""

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from updamp.fem.lumped_damper import DAMPER_MODELS
from updamp.geometry.rig_mesh import mirrored_mesh
from updamp.geometry.write_vtu import write_vtu
from updamp.hbm.analysis.adaptive import with_orders
from updamp.hbm.analysis.settings import setting_of, with_setting
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.newton.observe import contact_states
from updamp.hbm.problem.system import NonlinearSystem
from updamp.hbm.stability.branch_stability import BranchStability
from updamp.model.build import rig_model
from updamp.pictures import bodies, faces, kinematics, response
from updamp.pictures.modes import ModeShape, animation, panel
from updamp.pictures.scene import RenderingError
from updamp.workflow import stages, summary
from updamp.workflow.accuracy_summary import numerical_error
from updamp.workflow.adaptive_curves import ChosenHarmonics, chosen_file
from updamp.workflow.products import Products, Stored, stored
from updamp.workflow.run import Run
from updamp.workflow.summary import write_responses

# Files made from stage products for people and other programs: made again only when their sources have changed.


class Outputs:
    """Remembers in one file which key each output was made with."""

    def __init__(self, folder: Path, record: Path) -> None:
        self.folder, self.record = folder, record
        self._keys: dict[str, str] = {}
        with suppress(OSError, ValueError):  # none yet, or not one of ours: everything is made anew
            self._keys = dict(json.loads(record.read_text(encoding="utf-8")))

    def make(self, name: str, sources: Iterable[str], version: int, write: Callable[[Path], object]) -> bool:
        """Let `write` make folder/name, unless it is there and was made from the same sources by the same version.

        sources: keys of the stage products that go in, or anything else that does, as text
        returns: whether it was made
        """
        path = self.folder / name
        key = hashlib.sha256(json.dumps([version, *sources]).encode()).hexdigest()
        if self._keys.get(name) == key and path.exists():
            return False
        path.parent.mkdir(parents=True, exist_ok=True)
        write(path)
        self._keys[name] = key
        self.record.parent.mkdir(parents=True, exist_ok=True)
        temporary = self.record.with_suffix(".tmp")
        temporary.write_text(json.dumps(self._keys, indent=1), encoding="utf-8")
        temporary.replace(self.record)
        return True


CSV_VERSION, PICTURE_VERSION, VTU_VERSION = 2, 3, 1  # to be raised when a file of the same products looks different

BLADE_SHAPES = 4  # of the free blade, beside the two coupled ones


def write_outputs(run: Run, products: Products) -> tuple[tuple[str, ...], str]:
    """Files made anew, by name; and why those that need rendering were not, "" if they were. raises: OSError"""
    outputs = Outputs(run.options.folder, run.options.folder / "stages" / "outputs.json")
    made = [*_meshes(outputs, products), *_tables(outputs, products)]
    try:
        for name, sources, draw in _pictures(run, products):
            run.display.update("pictures", 0.0, name)
            if outputs.make(name, sources, PICTURE_VERSION, draw):
                made.append(name)
    except RenderingError as error:
        return tuple(made), str(error)
    return tuple(made), ""


def _meshes(outputs: Outputs, products: Products) -> list[str]:
    def write(path: Path) -> None:
        write_vtu(products.mesh.product, path.parent)

    name = "mesh/contacts.vtu"  # the last of the four that are written together
    return [name] if outputs.make(name, [products.mesh.stamp.key], VTU_VERSION, write) else []


def _tables(outputs: Outputs, products: Products) -> list[str]:
    made = []
    for mode, curves in _by_mode(products).items():
        name, keys = f"frf_{mode}.csv", [*_keys(products, mode), *_stability_keys(products, mode)]

        stability = products.stability_of(mode)

        def write(
            path: Path,
            curves: Sequence[ResponseCurve] = curves,
            stability: Mapping[float, BranchStability] = stability,
        ) -> None:
            write_responses(path, curves, stability)

        if outputs.make(name, keys, CSV_VERSION, write):
            made.append(name)
    return made


def _by_mode(products: Products) -> Mapping[str, Sequence[ResponseCurve]]:
    modes: dict[str, list[ResponseCurve]] = {}
    for curve in products.curves:
        if len(curve.product):
            modes.setdefault(curve.product.mode, []).append(curve.product)
    return modes


def _keys(products: Products, mode: str) -> list[str]:
    return [curve.stamp.key for curve in products.curves if curve.product.mode == mode]


def _stability_keys(products: Products, mode: str) -> list[str]:
    return [entry.stamp.key for entry in products.stability if entry.product.mode == mode]


# --- pictures: file, what it is made of, what draws it. Those by matplotlib first: they need no system libraries ---

Picture = tuple[str, Sequence[str], Callable[[Path], None]]


def _pictures(run: Run, products: Products) -> list[Picture]:
    return [*_plots(run, products), *_renderings(products)] if run.options.pictures else []


def _plots(run: Run, products: Products) -> list[Picture]:
    pictures: list[Picture] = []
    contacts, rest = products.mesh.product.contacts, products.static_contact
    if rest is not None:
        state = rest.product
        pictures.append(("pictures/pressure.png", [rest.stamp.key], lambda path: faces.pressure(path, contacts, state)))
    modes, point = _by_mode(products), run.response_point
    for mode, curves in modes.items():
        keys = _keys(products, mode)
        finer = [curve for curve in products.finer if curve.product.mode == mode and len(curve.product)]

        def draw_responses(
            path: Path,
            mode: str = mode,
            curves: Sequence[ResponseCurve] = curves,
            finer: Sequence[Stored[ResponseCurve]] = finer,
        ) -> None:
            others = [curve.product for curve in finer]
            response.frequency_responses(path, mode, curves, point, others, products.stability_of(mode))

        def draw_states(path: Path, mode: str = mode, curves: Sequence[ResponseCurve] = curves) -> None:
            faces.contact_states(path, contacts, mode, states_at_peaks(run, products, curves))

        sources = [point, *keys, *(curve.stamp.key for curve in finer), *_stability_keys(products, mode)]
        pictures.append((f"pictures/frf_{mode}.png", sources, draw_responses))
        pictures.append((f"pictures/contact_states_{mode}.png", [point, *keys], draw_states))
    if modes:
        lowest = {mode: min(curves, key=lambda curve: curve.force) for mode, curves in modes.items()}
        places = {mode: (curve, peak_place(run, curve)) for mode, curve in lowest.items()}
        keys = [key for mode in modes for key in _keys(products, mode)]
        pictures.append(
            ("pictures/damper_motion.png", keys, lambda path: kinematics.damper_kinematics(path, run.rig, places))
        )
    return pictures


def _renderings(products: Products) -> list[Picture]:
    mesh = products.mesh
    pictures: list[Picture] = [
        ("pictures/mesh.png", [mesh.stamp.key], lambda path: bodies.mesh(path, mesh.product)),
    ]
    if products.finite_elements is not None:
        keys = [entry.stamp.key for entry in (products.finite_elements, products.coupled_check) if entry is not None]
        pictures.append(("pictures/modes.png", keys, lambda path: panel(path, mode_shapes(products))))
        first = 1 if products.coupled_check is not None else 0  # IP where the coupled modes are known
        pictures.append(("pictures/mode.gif", keys, lambda path: animation(path, mode_shapes(products)[first])))
    return pictures


def mode_shapes(products: Products) -> tuple[ModeShape, ...]:
    """The stuck OOP and IP modes where the coupled check was made, then the first of the free blade."""
    mesh, result = products.mesh.product, products.finite_elements
    assert result is not None, "mode shapes come with the finite elements"
    shapes = []
    if products.coupled_check is not None:
        check, left = products.coupled_check.product, mirrored_mesh(mesh.blade)
        for mode, number in (("OOP", check.out_of_phase), ("IP", check.in_phase)):
            shape = check.shapes[mode]
            bodies = ((mesh.blade, "blade_right"), (left, "blade_left"), (mesh.damper, "damper"))
            parts = tuple((body, shape[name]) for body, name in bodies)
            shapes.append(ModeShape(f"{mode}, stuck: {check.full[number]:.1f} Hz", parts))
    blade = result.product
    for i, shape in enumerate(blade.blade_shapes[:BLADE_SHAPES]):
        shapes.append(
            ModeShape(f"free blade, mode {i + 1}: {blade.blade_frequencies[i]:.1f} Hz", ((mesh.blade, shape),))
        )
    return tuple(shapes)


def peak_place(run: Run, curve: ResponseCurve) -> int:
    return int(abs(curve.receptance(run.response_point)).argmax())


def states_at_peaks(run: Run, products: Products, curves: Sequence[ResponseCurve]) -> dict[float, Any]:
    """force -> (n_patches,) ContactState over a period at the point of largest response."""
    system = nonlinear_system(run, products)
    element = DAMPER_MODELS[run.rig.damper_model].element_of_patch(products.mesh.product.contacts)
    states = {}
    for curve in curves:
        place = peak_place(run, curve)
        w = 2 * np.pi * curve.frequency[place]
        its_own = with_setting(system, with_orders(setting_of(system), curve.orders))
        states[curve.force] = contact_states(its_own, curve.displacement[place], w)[element]
    return states


def nonlinear_system(run: Run, products: Products) -> NonlinearSystem:
    assert products.finite_elements is not None, "a curve has a reduced model"
    assert products.static_contact is not None, "a curve has a rest state"
    return rig_model(products.finite_elements.product.reduced, products.static_contact.product, run.rig).system


# --- summary ---


def _chosen(curve: Stored[ResponseCurve]) -> ChosenHarmonics | None:
    """None where the rig file states the harmonics"""
    found = stored(chosen_file(curve.path), ChosenHarmonics, curve.stamp.key)
    return found.product if found is not None else None


def summarise(run: Run, products: Products, seconds: float, peak_memory: float) -> dict[str, Any]:
    """seconds, peak_memory [bytes]: of the present run. Stages taken from their files report what they once cost."""
    stamps = products.stamps
    parts = ("mesh", "assembly", "modes", "reduction", "coupled_check", "static_contact")
    timing = {part: sum(stamp.seconds.get(part, 0.0) for stamp in stamps) for part in parts}
    timing["hbm"] = summary.union_length(
        [i for curve in (*products.curves, *products.finer) for i in curve.stamp.intervals]
    )
    timing["stability"] = summary.union_length([i for entry in products.stability for i in entry.stamp.intervals])
    timing["accuracy"] = summary.union_length([i for entry in products.point_errors for i in entry.stamp.intervals])
    content: dict[str, Any] = {
        "rig": run.rig.name,
        "mesh_preset": run.options.preset,
        "code": f"updamp {version('updamp')}",
        "mesh": summary.mesh_entry(products.mesh.product),
    }
    if products.finite_elements is not None:
        content["modes"] = summary.modes_entry(products.finite_elements.product)
    if products.coupled_check is not None:
        content["coupled_linear"] = summary.coupled_entry(products.coupled_check.product)
    if products.static_contact is not None:
        content["static_contact"] = summary.static_entry(products.static_contact.product)
    if run.wanted(stages.CURVE):
        content["curves"] = [
            summary.curve_entry(
                curve,
                run.response_point,
                numerical_error(products, curve, run.response_point) if run.options.accuracy else None,
                products.stability_of(curve.mode).get(curve.force),
                _chosen(entry),
            )
            for entry, curve in ((entry, entry.product) for entry in products.curves)
        ]
        content["not_said"] = {outcome.job.name: outcome.message for outcome in products.unknown}
        content["failed_curves"] = {outcome.job.name: outcome.message for outcome in products.failures}
    content["timing_s"] = {
        **{name: round(value, 3) for name, value in timing.items()},
        "total": round(seconds, 3),
        "all_stages_when_computed": round(sum(timing.values()), 3),
    }
    content["timing_note"] = (
        "total: wall time of the run that wrote this file; the others: of the stages when they were computed"
    )
    content["peak_memory_GB"] = round(max(peak_memory, *(stamp.peak_memory for stamp in stamps)) / 1e9, 3)
    return content
