"""What a script or a notebook imports: from a rig file to responses, to the comparison with a test, to what is missing.

    from updamp.api import build_model, load_rig, response_curve
    model = build_model(load_rig("rigs/pesaresi2017.toml"), mesh="small")
    response_curve(model, "OOP", force=3.84).plot().savefig("OOP.png")

SI everywhere: newton, metre, hertz; receptance in m/N. Names and arguments stay the same from version to version; what
else the package holds may move. Linear algebra runs on one thread in all calls, as it is many small products;
processes (`jobs`) are what uses more processors.
"""

from collections.abc import Mapping, Sequence
from numbers import Real
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console

from updamp.comparison.comparison import Comparison
from updamp.diagnosis.criteria import Criteria, SearchEffort
from updamp.diagnosis.verdict import Verdict
from updamp.effects.catalogue import catalogue
from updamp.effects.effect import Effect, EffectParameter
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import with_point_element
from updamp.hbm.compilation_cache import keep_compiled
from updamp.hbm.continuation.continuation import ContinuationOptions
from updamp.hbm.continuation.curve import CurveRequest, whole_curve
from updamp.hbm.continuation.curve_records import observed_points
from updamp.hbm.resonance.conditions import MaximumResonance, PhaseResonance, ResonanceCondition
from updamp.hbm.resonance.resonance_curve import ResonanceRequest, whole_resonance
from updamp.hbm.resonance.resonance_steps import ResonanceOptions
from updamp.measurement.load import load_measurement
from updamp.measurement.measurement import Measurement, MeasurementError
from updamp.model.rig_files import load_any
from updamp.notebook.curve import Curve
from updamp.notebook.model import Model
from updamp.notebook.outcomes import ComparisonResult, DiagnosisResult
from updamp.notebook.resonance import Resonance
from updamp.parallel.resources import on_one_blas_thread
from updamp.rig.errors import RigError
from updamp.rig.modal_rig import ModalRig
from updamp.rig.rig import Rig
from updamp.workflow.model_of_rig import model_of_rig

if TYPE_CHECKING:
    from updamp.workflow.add import Changed

__all__ = [
    "Comparison", "ComparisonResult", "ContinuationOptions", "Criteria", "Curve", "DiagnosisResult", "Effect",
    "EffectParameter", "MaximumResonance", "Measurement", "MeasurementError", "ModalRig", "Model", "PhaseResonance",
    "Resonance", "ResonanceCondition", "ResonanceOptions", "Rig", "RigError", "RigModel", "SearchEffort", "Verdict",
    "add_effect", "build_model", "catalogue", "compare", "diagnose", "keep_compiled", "load_measurement", "load_rig",
    "resonance", "response_curve", "with_point_element",
]  # fmt: skip

File = str | PathLike[str]


def load_rig(path: File, changes: Mapping[str, Any] | None = None) -> Rig | ModalRig:
    """Read and check a rig file: a rig with geometry, or one given by modes (`kind = "modal"`).

    changes: values that replace the file's own, written as in the file, by dotted path, such as
        {"contact.friction_coefficient": 0.4, "load.pull": "900 N"}
    raises: RigError with every problem found, one a line
    """
    return load_any(_path(path, "rig"), changes)


@on_one_blas_thread
def build_model(rig: Rig | ModalRig | File, mesh: str = "small", folder: File | None = None) -> Model:
    """The model of a rig as `updamp run`, `compare` and `diagnose` solve it, with the calibration and the effects that
    its file states. For a rig with geometry: mesh, finite elements, contact at rest, then the coupled equations.

    rig: as loaded, or its file; mesh: preset of the rig file, without meaning for a rig given by modes
    folder: of `updamp run` or of an earlier call: stages that still hold are taken from their files there and missing
        ones stored; without it all is computed in memory (mesh "small": some 10 s, "full": minutes and 7 GB)
    raises: RigError; ValueError naming a mesh, an effect or a factor that the rig has no place for
    """
    rig = rig if isinstance(rig, Rig | ModalRig) else load_rig(rig)
    parts = model_of_rig(rig, mesh, _path(folder, "folder") if folder is not None else None)
    preset = "" if isinstance(rig, ModalRig) else mesh
    return Model(rig, preset, parts, tuple(effect.name for effect in rig.effects))


@on_one_blas_thread
def response_curve(
    model: Model,
    window: str | tuple[float, float],
    force: float,
    points: str | Sequence[str] | None = None,
    *,
    upwards: bool = True,
    options: ContinuationOptions | None = None,
) -> Curve:
    """The periodic responses to a harmonic force at the model's excitation, through a window of frequencies, with
    turning points and what lies between them. It is traced in this process; `updamp run` traces several at a time.

    window: name of a mode of the study, such as "OOP", or lower and upper frequency [Hz]; force: amplitude [N]
    points: where the response is shown, by default at `model.response_point`; all points of the model are kept
    upwards: begin at the lower end; options: steps and tolerances
    returns: the curve; where the branch could not be followed to the end, `stopped` says why and what to try
    raises: ValueError naming a mode, window, force or point that cannot be
    """
    name, frequencies = _window(model, window)
    reported = _points(model, points)
    every = tuple(dict.fromkeys((*reported, *observed_points(model.system.free))))
    excitation, options = model.parts.excited_by(_force(force)), options or ContinuationOptions()
    request = CurveRequest(name, excitation, frequencies, every, upwards, options, told=reported)
    return Curve(whole_curve(model.system, request), reported)


@on_one_blas_thread
def resonance(
    model: Model,
    window: str | tuple[float, float],
    forces: float | Sequence[float],
    point: str | None = None,
    *,
    condition: ResonanceCondition | None = None,
    options: ResonanceOptions | None = None,
) -> Resonance:
    """The resonance of one mode against force (backbone), without the response curves around it.

    window: as for `response_curve`; the stuck structure's resonance has to lie in it, and of several the one that
        responds most is followed; of a mode that the rig file states, its own
    forces: amplitudes [N], all rising or all falling, or a single one; point: as for `response_curve`
    condition: what is meant by resonance: `MaximumResonance()`, the default, or `PhaseResonance(target)` [rad]
    returns: the resonance; where it could not be followed to the last force, `stopped` says why
    raises: ValueError naming a mode, window, force or point that cannot be
    """
    name, frequencies = _window(model, window)
    (observed,) = _points(model, point)
    wanted = (_force(forces),) if np.ndim(forces) == 0 else tuple(map(_force, np.asarray(forces)))
    stated = model.rig.modes[name].frequency if isinstance(model.rig, ModalRig) and name in model.rig.modes else None
    request = ResonanceRequest(
        name, model.parts.excitation, observed, frequencies, wanted, condition or MaximumResonance(), options,
        mode_frequency=stated,
    )  # fmt: skip
    return Resonance(whole_resonance(model.system, request))


# The three below import on call: reports and pictures (plotly, matplotlib) take a second to load, and an effect's file,
# which imports this module, is read by every process of a diagnosis.


@on_one_blas_thread
def compare(
    rig: File,
    measurement: File,
    out: File,
    mesh: str = "full",
    *,
    finer: Sequence[str] | None = None,
    jobs: int = 1,
    quiet: bool = False,
) -> ComparisonResult:
    """Lay a model over a measurement, as `updamp compare`: what is known only roughly (stiffness, damping, friction) is
    fitted within its bounds, then every misfit beyond the scatter is told. Writes comparison.json and report.html.

    rig, measurement: files; out: folder for all that is written; that of a run, to use its stages
    mesh: preset of the rig file; finer: presets with finer meshes or more contact elements: what they change counts as
        numerical error; by default the next finer ones of the rig file, () for none
    jobs: processes; with more than one, a script must call this under `if __name__ == "__main__":`
    quiet: no progress on the terminal
    raises: RigError, MeasurementError, ValueError: naming file, value and remedy
    """
    from updamp.workflow.compare_run import run_compare
    from updamp.workflow.comparison_inputs import CompareFiles

    files = CompareFiles(_path(rig, "rig"), _path(measurement, "measurement"), _path(out, "out"))
    comparison, _ = run_compare(files, mesh, jobs, Console(quiet=quiet), _names(finer))
    return ComparisonResult(comparison, files.report_of_comparison)


@on_one_blas_thread
def diagnose(
    rig: File,
    measurement: File,
    out: File,
    mesh: str = "full",
    *,
    finer: Sequence[str] | None = None,
    held_out: Sequence[str] | None = None,
    held_out_modes: Sequence[str] = (),
    own_effects: Sequence[File] = (),
    jobs: int = 1,
    scheduler: str = "",
    report: bool = True,
    next_measurement: bool = True,
    dimensions: Sequence[str] | None = None,
    criteria: Criteria | None = None,
    quiet: bool = False,
) -> DiagnosisResult:
    """Say which physical effect a model lacks, as `updamp diagnose`: effects of the catalogue are tried on some of the
    runs and judged on the others. Writes diagnosis.json and report.html; one that was stopped goes on where it was.

    rig, measurement, out, mesh, finer, jobs, quiet: as for `compare`
    held_out: names of runs that no fit sees, None for one level of each mode; held_out_modes: all runs of these modes
    own_effects: files of your own effects; scheduler: address of a Dask scheduler whose workers replace `jobs`
    report: whether to write report.html; next_measurement: whether to look for the run that tells apart what is left
    dimensions: of the rig that may be other than stated, by the effects' names, for which the model is built once more
        each; by default all that updamp knows, () for none
    criteria: what is decided by
    raises: RigError, MeasurementError, ValueError: naming file, value and remedy
    """
    from updamp.workflow.comparison_inputs import CompareFiles
    from updamp.workflow.diagnose_run import DiagnoseOptions
    from updamp.workflow.diagnose_run import diagnose as search

    files = CompareFiles(_path(rig, "rig"), _path(measurement, "measurement"), _path(out, "out"))
    options = DiagnoseOptions(
        finer=_names(finer), dimensions=_names(dimensions), held_out=None if held_out is None else tuple(held_out),
        held_out_modes=tuple(held_out_modes), own=tuple(_path(file, "own_effects") for file in own_effects),
        jobs=jobs, scheduler=scheduler, report=report, next_measurement=next_measurement,
        criteria=criteria or Criteria(),
    )  # fmt: skip
    found = search(files, mesh, options, Console(quiet=quiet))
    return DiagnosisResult(found, files.out, files.report if report else None)


def add_effect(
    rig: File,
    diagnosis: File,
    effects: str | Sequence[str] = (),
    *,
    out: File | None = None,
    replace: bool = False,
    with_calibration: bool = False,
    own_effects: Sequence[File] = (),
) -> "Changed":
    """Write a new rig file with effects at the values that a diagnosis fitted, as `updamp add`, and its history. To try
    an effect at values of your own, without a file: `Model.with_effect`.

    rig: file; diagnosis: folder of `diagnose`; effects: names, by default those that the diagnosis identified
    out: the new file, by default beside the old one with the effects in its name; replace: replace it where it is there
    with_calibration: take along what was calibrated together with the effects
    own_effects: files of effects of your own that are among `effects`
    returns: `rig` (path of the new file), `step` (errors before and after) and `notes` (what to know about it)
    raises: RigError; ValueError with every problem found, one a line
    """
    from updamp.workflow.add import AddOptions, add

    own = tuple(_path(file, "own_effects") for file in own_effects)
    options = AddOptions(_path(out, "out") if out is not None else None, replace, with_calibration, own)
    names = (effects,) if isinstance(effects, str) else tuple(effects)
    return add(_path(rig, "rig"), names, _path(diagnosis, "diagnosis"), options)


def _path(value: Any, name: str) -> Path:
    if not isinstance(value, str | PathLike):
        raise ValueError(f"{name}: a {type(value).__name__} was given; give the path of a file or folder")
    return Path(value)


def _names(names: Sequence[str] | None) -> tuple[str, ...] | None:
    return None if names is None else tuple(names)


def _window(model: Model, window: str | tuple[float, float]) -> tuple[str, tuple[float, float]]:
    if isinstance(window, str):
        if window not in model.modes:
            known = ", ".join(model.modes)
            raise ValueError(f'window = "{window}": no such mode; there are {known}; or give (low, high) in Hz')
        return window, model.modes[window]
    low, high = map(float, window)
    if not 0 < low < high:
        raise ValueError(f"window = ({low:g}, {high:g}): give the lower frequency first, both above 0 Hz")
    return f"{low:g}-{high:g} Hz", (low, high)


def _points(model: Model, points: str | Sequence[str] | None) -> tuple[str, ...]:
    wanted = (model.response_point,) if points is None else (points,) if isinstance(points, str) else tuple(points)
    if missing := [point for point in wanted if point not in model.points]:
        raise ValueError(f'point "{missing[0]}": the model has no such point; it has {", ".join(model.points)}')
    if not wanted:
        raise ValueError(f"points: none was named; the model has {', '.join(model.points)}")
    return wanted


def _force(value: Any) -> float:
    if not isinstance(value, Real) or not 0 < float(value) < float("inf"):
        raise ValueError(f"force = {value!r}: give its amplitude in newton, above 0, such as 3.84")
    return float(value)
