"""`updamp compare`: from a rig file and a measurement to comparison.json and report.html."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from importlib.metadata import version
from pathlib import Path

import numpy as np
from rich.console import Console

from updamp.comparison.compare import compare
from updamp.comparison.comparison import ASKED_FIRST, COMPARISON_JSON, Comparison, CurvePair, FeatureComparison
from updamp.comparison.findings.stated_values import WITHOUT_DAMPER, compare_features, needed
from updamp.comparison.fit.fit import Fit
from updamp.comparison.prediction.branch_tasks import Branches, InTurn, Report, by_processes
from updamp.effects.chosen import ChosenEffect, resolved, with_effects, with_tried_effects
from updamp.effects.rig_model import RigModel
from updamp.measurement.load import load_measurement
from updamp.measurement.measurement import Measurement
from updamp.model.build import modal_before_effects
from updamp.model.rig_files import is_modal, load_modal, load_rig
from updamp.pictures.curves import comparison_picture
from updamp.report.markup import drawn_units
from updamp.report.page import write_report
from updamp.rig.questions import questions
from updamp.rig.rig import Rig
from updamp.workflow.built_rig import built_rig, finer_rigs
from updamp.workflow.history import record_comparison
from updamp.workflow.measured_against_model import (
    another_pull,
    check_excitation,
    measured_against_model,
    unknown_modes,
)
from updamp.workflow.output_folder import STATE, check_folder, make_folder
from updamp.workflow.progress import Display
from updamp.workflow.response_files import matlab_name
from updamp.workflow.run import Run
from updamp.workflow.run_options import RunOptions

NUMERICAL_ERROR = "numerical error asked of"


@dataclass(frozen=True)
class CompareFiles:
    """What a comparison reads and where it writes."""

    rig: Path
    measurement: Path
    out: Path

    @property
    def comparison(self) -> Path:
        return self.out / "comparison.json"

    @property
    def report(self) -> Path:
        return self.out / "report.html"

    @property
    def report_of_comparison(self) -> Path:
        """Beside that of a diagnosis which the folder holds: hours of work, not to be replaced by minutes'."""
        return self.out / "comparison.html" if (self.out / "diagnosis.json").is_file() else self.report


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


@dataclass(frozen=True, eq=False)
class ComparisonInputs:
    """What is compared.

    before_effects: the model, calibrated as the rig file says
    rig_effects: effects of the rig file, to be applied after nuisance parameters (`Parametrisation`)
    rig: its name; rig_state: hash of what its file states; mesh: preset, "" for a model without
    finer: models with finer numerics, before effects too, by what is finer
    """

    before_effects: RigModel
    measurement: Measurement
    features: tuple[FeatureComparison, ...]
    mesh: str
    rig: str
    rig_state: str = ""
    finer: Mapping[str, RigModel] = field(default_factory=dict)
    rig_effects: tuple[ChosenEffect, ...] = ()


def comparison_inputs(
    files: CompareFiles,
    preset: str,
    workers: int,
    display: Display,
    finer: Sequence[str] | None = None,
    dimensions: Sequence[str] = (),
    check: Callable[[Measurement], None] = lambda _: None,
) -> ComparisonInputs:
    """The model, built where it is not there yet, and the measurement.

    dimensions: of which the models know what another value changes; of stated frequencies alone, none
    check: asked of the measurement before anything is built; what it raises is raised
    raises: RigError, MeasurementError and what the stages raise, naming what to mend
    """
    modal = is_modal(files.rig)
    inputs = (
        _of_modal_rig(files, check) if modal else _of_rig(files, check, preset, workers, display, finer, dimensions)
    )
    model = with_tried_effects(inputs.before_effects, inputs.rig_effects)
    asked = (*inputs.measurement.questions, *measured_against_model(model, inputs.measurement))
    for question in asked:
        display.note("question", question)
    if asked:
        display.note("check", ASKED_FIRST)
    return replace(inputs, measurement=replace(inputs.measurement, questions=asked)) if asked else inputs


def _of_rig(
    files: CompareFiles,
    check: Callable[[Measurement], None],
    preset: str,
    workers: int,
    display: Display,
    finer: Sequence[str] | None,
    dimensions: Sequence[str],
) -> ComparisonInputs:
    rig = load_rig(files.rig)
    measurement = load_measurement(files.measurement, _points(), rig.name)
    check_excitation(rig.excitation.point, measurement)
    check(measurement)
    about_runs = (*unknown_modes(measurement, tuple(rig.study.modes)), *another_pull(measurement, rig.load.pull))
    measurement = replace(measurement, questions=(*questions(rig), *measurement.questions, *about_runs))
    built = built_rig(rig, preset, files.out, workers, display)
    make_folder(files.out)
    finer_ones = finer_rigs(rig, preset, files.out, workers, display, finer) if measurement.runs else {}
    varied = built.varied(dimensions if measurement.runs else ())
    model = built.before_effects(varied)
    features = _features(files, rig, measurement, preset, workers, display, _free_frequency(model, rig))
    finer_models = {name: one.before_effects(one.varied_as(built, varied)) for name, one in finer_ones.items()}
    return ComparisonInputs(
        model, measurement, features, preset, rig.name, rig.state, finer_models, resolved(rig.effects)
    )


def _of_modal_rig(files: CompareFiles, check: Callable[[Measurement], None]) -> ComparisonInputs:
    rig = load_modal(files.rig)
    check_folder(files.out, rig.name)
    model = modal_before_effects(rig)
    measurement = load_measurement(files.measurement, model.components.points, rig.name)
    check(measurement)
    about_runs = (*measurement.questions, *unknown_modes(measurement, model.modes))
    measurement = replace(measurement, questions=about_runs)
    make_folder(files.out)
    return ComparisonInputs(model, measurement, (), "", rig.name, rig_effects=resolved(rig.effects))


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


def _points() -> tuple[str, ...]:
    """Names of the points that every model of such a rig has."""
    of_blade = ("excitation.x", "tip.x", "platform.x", "platform.y")
    of_damper = ("corner_left.x", "corner_left.y", "corner_right.x", "corner_right.y")
    blades = [f"blade_{side}.{point}" for side in ("left", "right") for point in of_blade]
    return (*blades, *(f"damper.{point}" for point in of_damper))


def _free_frequency(model: RigModel, rig: Rig) -> float:
    """Of the excited blade's first mode without damper, with the rig's effects [Hz]; model: before them"""
    whole = with_effects(model, resolved(rig.effects))
    of_blade = np.array(whole.owner) == f"blade_{rig.excitation.blade}"
    return float(whole.components.frequencies[of_blade].min())


def _features(
    files: CompareFiles,
    rig: Rig,
    measurement: Measurement,
    preset: str,
    workers: int,
    display: Display,
    free_frequency: float,
) -> tuple[FeatureComparison, ...]:
    """Stated values: the curves that they need are those of `updamp run`, in the same files."""
    if not measurement.features:
        return ()
    wanted = needed(measurement.features)
    peaks: dict[tuple[str, float], float] = {}
    for mode in dict.fromkeys(mode for mode, _ in wanted):
        forces = tuple(force for of_mode, force in wanted if of_mode == mode)
        run = Run(rig, RunOptions(preset, files.out, workers, (mode,), forces, check=False, pictures=False), display)
        for curve in (stored.product for stored in run.products().curves):
            # The largest response of a part of a curve may be no resonance, such as an end of the window.
            known = curve.complete and len(curve)
            peaks[mode, curve.force] = curve.peak(rig.response_point)[0] if known else float("nan")

    def resonance(mode: str, force: float) -> float:
        if WITHOUT_DAMPER in mode:
            return free_frequency
        if (mode, force) not in peaks:
            raise ValueError(f"the curve {mode} {force:g} N was not traced: see the lines above")
        return peaks[mode, force]

    return compare_features(measurement.features, resonance)


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
