"""What a comparison and a diagnosis begin with: the model, built where it is not there yet, and the measurement."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from updamp.comparison.comparison import ASKED_FIRST, FeatureComparison
from updamp.comparison.findings.stated_values import WITHOUT_DAMPER, compare_features, needed
from updamp.effects.chosen import ChosenEffect, resolved, with_effects, with_tried_effects
from updamp.effects.rig_model import RigModel
from updamp.fem.interface import BLADE_POINTS
from updamp.measurement.load import load_measurement
from updamp.measurement.measurement import Measurement
from updamp.model.build import modal_before_effects
from updamp.model.rig_files import is_modal, load_modal, load_rig
from updamp.rig.questions import questions
from updamp.rig.rig import Rig
from updamp.workflow.built_rig import built_rig, finer_rigs
from updamp.workflow.measured_against_model import (
    another_pull,
    check_excitation,
    measured_against_model,
    unknown_modes,
)
from updamp.workflow.output_folder import check_folder, make_folder
from updamp.workflow.progress import Display
from updamp.workflow.run import Run
from updamp.workflow.run_options import RunOptions


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
    measurement = load_measurement(files.measurement, model_points(), rig.name)
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


def model_points() -> tuple[str, ...]:
    """Names of the points that every model of such a rig has."""
    of_damper = ("corner_left.x", "corner_left.y", "corner_right.x", "corner_right.y")
    blades = [f"blade_{side}.{point}" for side in ("left", "right") for point in BLADE_POINTS]
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
