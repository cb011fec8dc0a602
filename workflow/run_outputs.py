"""What a run leaves for people and other programs: ParaView meshes, CSV, pictures, summary.json."""

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from typing import Any

from updamp.geometry.write_vtu import write_vtu
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.stability.branch_stability import BranchStability
from updamp.parallel.whole_file import write_whole, written_to
from updamp.pictures.scene import RenderingError
from updamp.workflow import stages, summary
from updamp.workflow.accuracy_summary import numerical_error
from updamp.workflow.adaptive_curves import ChosenHarmonics, chosen_file
from updamp.workflow.mode_names import misnamed_modes
from updamp.workflow.output_folder import results_of_other_states
from updamp.workflow.products import Products, Stored, stored
from updamp.workflow.quick_look import error_is_left, not_checked
from updamp.workflow.response_files import FORMATS, write_responses
from updamp.workflow.run import Run
from updamp.workflow.run_pictures import by_mode, curve_keys, pictures, stability_keys

# Files made from stage products for people and other programs: made again only when their sources have changed.


class Outputs:
    """Remembers in one file which key each output was made with, and of which state of the rig it is.

    state: hash of the rig file and the mesh; "" where it does not matter
    """

    def __init__(self, folder: Path, record: Path, state: str = "") -> None:
        self.folder, self.record, self.state = folder, record, state
        self._keys: dict[str, str] = {}
        self._states: dict[str, str] = {}
        self._current: set[str] = set()
        with suppress(OSError, ValueError, TypeError, AttributeError):  # none yet, or not ours: all is made anew
            content = json.loads(record.read_text(encoding="utf-8"))
            self._states = dict(content.pop(STATES, {}))
            self._keys = dict(content)

    def make(
        self,
        name: str,
        sources: Iterable[str],
        version: int,
        write: Callable[[Path], object],
        beside: Sequence[str] = (),
    ) -> bool:
        """Let `write` make folder/name, unless it is there and was made from the same sources by the same version.

        sources: keys of the stage products that go in, or anything else that does, as text
        beside: endings of what `write` makes beside it, such as ".svg"
        returns: whether it was made
        """
        path = self.folder / name
        self._current.add(name)
        key = hashlib.sha256(json.dumps([version, *sources]).encode()).hexdigest()
        if self._keys.get(name) == key and all(one.exists() for one in (path, *_with(path, beside))):
            if self._states.get(name) != self.state:
                self._states[name] = self.state
                self._remember()
            return False
        with written_to(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            write(path)
        self._keys[name], self._states[name] = key, self.state
        self._remember()
        return True

    def remove_older(self) -> tuple[str, ...]:
        """Names of the outputs that are taken away: not asked for this time, and of another state of the rig."""
        older = [
            name for name in self._keys
            if name not in self._current and self._states.get(name, self.state) != self.state
        ]  # fmt: skip
        for name in older:
            for path in (self.folder / name, *_with(self.folder / name, BESIDE)):
                path.unlink(missing_ok=True)
            del self._keys[name], self._states[name]
        if older:
            self._remember()
        return tuple(older)

    def _remember(self) -> None:
        write_whole(self.record, json.dumps({**self._keys, STATES: self._states}, indent=1).encode())


def _with(path: Path, endings: Iterable[str]) -> list[Path]:
    return [path.with_suffix(ending) for ending in endings]


BESIDE = (".svg", ".pdf", ".uff", ".mat")  # what is made beside a file and goes with it
STATES = "states"  # among the names of outputs, which all have an ending
CSV_VERSION, PICTURE_VERSION, VTU_VERSION = 3, 6, 1  # to be raised when a file of the same products looks different


def write_outputs(run: Run, products: Products) -> tuple[tuple[str, ...], str]:
    """Files made anew, by name; and why those that need rendering were not, "" if they were. Those of an older state of
    the rig are removed. raises: DiskError"""
    outputs = Outputs(run.options.folder, run.options.folder / "stages" / "outputs.json", _state(run))
    made = [*_meshes(outputs, products), *_tables(outputs, products)]
    try:
        for one in pictures(run, products):
            run.display.update("pictures", 0.0, one.name)
            if outputs.make(one.name, one.sources, PICTURE_VERSION, one.draw, one.beside):
                made.append(one.name)
    except RenderingError as error:
        return tuple(made), str(error)
    finally:
        if older := outputs.remove_older():
            run.display.note("files", f"of an older state of the rig, removed: {', '.join(older)}")
        for name in results_of_other_states(run.options.folder, run.rig.state):
            run.display.note("files", f"{name} is of an older state of the rig: make it again, or take another --out")
    return tuple(made), ""


def _state(run: Run) -> str:
    return hashlib.sha256(f"{run.options.preset} {run.rig.state}".encode()).hexdigest()


def _meshes(outputs: Outputs, products: Products) -> list[str]:
    def write(path: Path) -> None:
        write_vtu(products.mesh.product, path.parent)

    name = "mesh/contacts.vtu"  # the last of the four that are written together
    return [name] if outputs.make(name, [products.mesh.stamp.key], VTU_VERSION, write) else []


def _tables(outputs: Outputs, products: Products) -> list[str]:
    made = []
    for mode, curves in by_mode(products).items():
        name, keys = f"frf_{mode}.csv", [*curve_keys(products, mode), *stability_keys(products, mode)]

        stability = products.stability_of(mode)

        def write(
            path: Path,
            curves: Sequence[ResponseCurve] = curves,
            stability: Mapping[float, BranchStability] = stability,
        ) -> None:
            write_responses(path, curves, stability)

        if outputs.make(name, keys, CSV_VERSION, write, FORMATS):
            made.append(name)
    return made


# --- summary ---


def _chosen(curve: Stored[ResponseCurve]) -> ChosenHarmonics | None:
    """None where the rig file states the harmonics"""
    found = stored(chosen_file(curve.path), ChosenHarmonics, curve.stamp.key)
    return found.product if found is not None else None


def _error(run: Run, products: Products, curve: ResponseCurve) -> dict[str, Any] | None:
    """None where it was not asked for"""
    if not run.options.accuracy or error_is_left(products.left, curve):
        return None
    return numerical_error(products, curve, run.rig.response_point)


def _of_curves(run: Run, products: Products) -> dict[str, Any]:
    followed = {entry.product.mode: entry.product for entry in products.resonances}
    part = run.options.part(tuple(run.rig.study.modes))
    return {
        "curves": [
            summary.curve_entry(
                curve,
                run.rig.response_point,
                _error(run, products, curve),
                products.stability_of(curve.mode).get(curve.force),
                _chosen(entry),
                products.detached_of(curve.mode).get(curve.force),
                products.marched_of(curve.mode).get(curve.force),
                followed.get(curve.mode),
            )
            for entry, curve in ((entry, entry.product) for entry in products.curves)
        ],
        **({"part": part} if part else {}),
        "misnamed_modes": misnamed_modes(products, run.rig.response_point),
        "not_checked": not_checked(products, run.options),
        "not_known": {outcome.job.name: outcome.message for outcome in products.unknown},
        "failed_curves": {outcome.job.name: outcome.message for outcome in products.failures},
        "resonances": [
            summary.resonance_entry(entry.product, run.rig.study.force_levels) for entry in products.resonances
        ],
    }


def summarise(run: Run, products: Products, seconds: float, peak_memory: float) -> dict[str, Any]:
    """seconds, peak_memory [bytes]: of the present run. Stages taken from their files report what they once cost."""
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
        content |= _of_curves(run, products)
    timing = _timing(products)
    content["timing_s"] = {
        **{name: round(value, 3) for name, value in timing.items()},
        "total": round(seconds, 3),
        "all_stages_when_computed": round(sum(timing.values()), 3),
    }
    content["timing_note"] = (
        "total: wall time of the run that wrote this file; the others: of the stages when they were computed"
    )
    content["peak_memory_GB"] = round(max(peak_memory, *(stamp.peak_memory for stamp in products.stamps)) / 1e9, 3)
    return content


def _timing(products: Products) -> dict[str, float]:
    """Wall time [s] of each stage when it was computed; what ran beside each other is counted once."""
    parts = ("mesh", "assembly", "modes", "reduction", "coupled_check", "static_contact")
    timing = {part: sum(stamp.seconds.get(part, 0.0) for stamp in products.stamps) for part in parts}
    beside_each_other: dict[str, Sequence[Stored[Any]]] = {
        "hbm": (*products.curves, *products.finer),
        "stability": products.stability,
        "marching": products.marched,
        "resonance": products.resonances,
        "detached": products.detached,
        "accuracy": products.point_errors,
    }
    for name, entries in beside_each_other.items():
        timing[name] = summary.union_length([i for entry in entries for i in entry.stamp.intervals])
    return timing
