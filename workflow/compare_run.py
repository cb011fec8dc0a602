"""`updamp compare`: from a rig file and a measurement to comparison.json and report.html."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path

from rich.console import Console

from updamp.comparison.compare import compare
from updamp.comparison.comparison import COMPARISON_JSON, Comparison, CurvePair
from updamp.comparison.fit.fit import Fit
from updamp.comparison.prediction.branch_tasks import Branches, InTurn, Report, by_processes
from updamp.effects.chosen import with_effects
from updamp.pictures.curves import comparison_picture
from updamp.report.markup import drawn_units
from updamp.report.page import write_report
from updamp.workflow.comparison_inputs import CompareFiles, ComparisonInputs, comparison_inputs
from updamp.workflow.history import record_comparison
from updamp.workflow.output_folder import STATE
from updamp.workflow.progress import Display
from updamp.workflow.response_files import matlab_name

NUMERICAL_ERROR = "numerical error asked of"


def run_compare(
    files: CompareFiles,
    preset: str,
    workers: int,
    console: Console,
    finer: Sequence[str] | None = None,
) -> tuple[Comparison, Fit | None]:
    """Build the model where it is not there yet, compare, write both files.

    workers: processes at most; the numbers do not depend on it
    finer: presets of finer meshes; what each changes counts as numerical error; None for the next finer ones of the rig
        file (`finer_presets`)

    raises: RigError, MeasurementError and what the stages raise, naming what to mend
    """
    with Display(console) as display:
        inputs = comparison_inputs(files, preset, workers, display, finer)
        provenance = provenance_of(files, inputs, preset)
        display.update("comparison", 0.0, "prediction")
        progress = _ProgressBar(display)
        with branches_of(inputs, workers, progress.branch) as branches:
            comparison, fit = compare(
                inputs.before_effects,
                inputs.measurement,
                inputs.features,
                provenance,
                progress=progress,
                finer=inputs.finer,
                rig_effects=inputs.rig_effects,
                branches_of=branches,
            )
        display.done("comparison", f"findings: {len(comparison.findings)}")
        for odd in comparison.to_look_at:
            display.note("check", odd)
        COMPARISON_JSON.write(files.comparison, comparison)
        write_report(comparison, files.report_of_comparison, pictures_of(files.out))
        write_pictures(comparison, files.out)
        record_comparison(files.rig, tuple(one.effect.name for one in inputs.rig_effects), comparison)
        display.done("files", f"{files.comparison}, {files.report_of_comparison}")
    return comparison, fit


@contextmanager
def branches_of(inputs: ComparisonInputs, workers: int, report: Report) -> Iterator[Branches]:
    """How the branches of a comparison are traced: in at most so many processes, and no more than it has tests. Those
    of a model that is linear take less time than a process takes to begin."""
    tests = len({run.name for run in inputs.measurement.runs})
    linear = not with_effects(inputs.before_effects, inputs.rig_effects).groups
    if min(workers, tests) < 2 or linear:
        yield InTurn(report)
    else:
        with by_processes(min(workers, tests), report) as spread:
            yield spread


class _ProgressBar:
    """The fit does not know how many rounds it will need: the bar tells what it is at."""

    def __init__(self, display: Display) -> None:
        self._display, self._share, self._step = display, 0.0, ""

    def __call__(self, step: str) -> None:
        self._share, self._step = self._share + (1 - self._share) / 6, step
        self._display.step("comparison", self._share, step)

    def branch(self, name: str, done: int, of: int) -> None:
        """One more of the branches that the step needs."""
        share = self._share + (1 - self._share) / 6 * done / of
        self._display.update("comparison", share, f"{self._step}: {name}, {done} of {of} branches")


def provenance_of(files: CompareFiles, inputs: ComparisonInputs, preset: str) -> Mapping[str, str]:
    hashes = {f"SHA-256 of {name}": value for name, value in (inputs.measurement.hashes or {}).items()}
    of_mesh = {"mesh": preset} if inputs.mesh else {}
    effects = (
        {"effects of the rig file": ", ".join(one.effect.name for one in inputs.rig_effects)}
        if inputs.rig_effects
        else {}
    )
    return {
        "rig": inputs.rig,
        **({STATE: inputs.rig_state} if inputs.rig_state else {}),
        "rig file": str(files.rig),
        "measurement": str(files.measurement),
        **of_mesh,
        **({NUMERICAL_ERROR: ", ".join(("more harmonics and time samples", *inputs.finer))} if inputs.mesh else {}),
        **effects,
        "updamp": version("updamp"),
        **hashes,
    }


def write_pictures(comparison: Comparison, folder: Path) -> None:
    """Model over measurement, a picture a mode, for documents: compared_OOP.png, .svg and .pdf"""
    modes: dict[str, list[CurvePair]] = {}
    for pair in comparison.curves:
        modes.setdefault(pair.mode, []).append(pair)
    for mode, pairs in modes.items():
        path = folder / "pictures" / f"compared_{matlab_name(mode)}.png"
        comparison_picture(path, f"{mode}: model and test", pairs, drawn_units(comparison).receptance)


def pictures_of(folder: Path) -> dict[str, bytes]:
    """Those of the contacts, where `updamp run` has drawn them into the same folder."""
    captions = {
        "pressure.png": "Pressure at rest",
        "contact_states_OOP.png": "Contact states, OOP",
        "contact_states_IP.png": "Contact states, IP",
    }
    found = {caption: folder / "pictures" / name for name, caption in captions.items()}
    return {caption: path.read_bytes() for caption, path in found.items() if path.is_file()}
