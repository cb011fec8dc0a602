"""Calibrations behind the sentences, kept: `updamp compare` but for what is said in the end."""

import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path

from updamp.benchmarks.hidden_effects.cases import Case
from updamp.benchmarks.hidden_effects.fitted_model import FINER, place
from updamp.benchmarks.hidden_effects.layout import Layout
from updamp.benchmarks.virtual_rig.measurement import RIG
from updamp.comparison.compare import CalibrationResult, calibrate
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.measurement.measurement import Measurement
from updamp.workflow.code_version import SEARCH, code_version
from updamp.workflow.compare_run import provenance_of
from updamp.workflow.comparison_inputs import CompareFiles, comparison_inputs
from updamp.workflow.kept_results import ResultKey, inputs_digest, read_result, write_result
from updamp.workflow.progress import Display

FITTED = "diagnosis"


@dataclass(frozen=True, eq=False)
class KeptCalibration:
    """A finished calibration. seconds: that it took, on the clock"""

    calibration: CalibrationResult
    measurement: Measurement
    provenance: Mapping[str, str]
    seconds: float


def calibrated(case: Case, data: Layout, folder: Path, models: Path) -> KeptCalibration:
    """As `updamp compare` does it, from the folder where this version of updamp has done it already."""
    store, key = folder / "calibration.pkl", _key(data.data(case.name))
    found: KeptCalibration | None = read_result(store, key, lambda sentence: print(sentence, file=sys.stderr))
    if found is not None:
        return found
    place(models / FITTED, folder, FINER[FITTED])
    started = time.perf_counter()
    files = CompareFiles(RIG, data.measurement(case.name), folder)
    with Display() as display:
        inputs = comparison_inputs(files, FITTED, 1, display, FINER[FITTED])
    done = calibrate(inputs.before_effects, inputs.measurement, finer=inputs.finer, rig_effects=inputs.rig_effects)
    seconds = time.perf_counter() - started
    kept = KeptCalibration(_slim(done), inputs.measurement, provenance_of(files, inputs, FITTED), seconds)
    write_result(store, key, kept)
    return kept


def _key(measured: Path) -> ResultKey:
    """measured: folder with the files of the measurement"""
    files = [RIG, *sorted(path for path in measured.iterdir() if path.is_file())]
    code = code_version(*SEARCH, "benchmarks/hidden_effects/sentence_runs.py")
    return ResultKey(
        code, inputs_digest(FITTED, *FINER[FITTED], *(sha256(path.read_bytes()).hexdigest() for path in files))
    )


def _slim(done: CalibrationResult) -> CalibrationResult:
    """Without what only moving a branch needs."""

    def slim(branches: Sequence[PredictedBranch]) -> tuple[PredictedBranch, ...]:
        return tuple(replace(b, x_by_parameter=()) for b in branches)

    compared = replace(done.fit.compared, branches=slim(done.fit.compared.branches))
    fit = replace(done.fit, compared=compared)
    return replace(done, before=slim(done.before), after=slim(done.after), fit=fit)
