"""One mode of the Brake-Reuss beam whose spring softens: the sweep jumps, and two parts of its branch overlap."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from updamp.comparison.prediction.model_at import ModelAt
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.comparison.prediction.traced_branch import observe
from updamp.effects.catalogue import JOINTS
from updamp.hbm.continuation.continuation import continue_branch
from updamp.model.build import modal_model
from updamp.model.calibration import nuisances
from updamp.model.rig_files import load_modal

POINT = "beam.drive.x"
# A softening spring bends the resonance by 20 half-widths.
DOWN = RunCondition("down", "first", 1.2, False, (76.5, 81.5), ((POINT, 1),))
UP = replace(DOWN, upwards=True)
SOFTENING = -1.0  # of the typical coefficient


def softening_beam() -> Parametrisation:
    beam = modal_model(load_modal(Path(__file__).parents[2] / "rigs" / "brake_reuss.toml"))
    return Parametrisation(beam, nuisances(beam), (JOINTS["joint_cubic"],))


def at(p: Parametrisation, stiffer: float = 0.0) -> np.ndarray:
    return np.array([stiffer, *np.zeros(len(p) - 2), SOFTENING])


def whole(p: Parametrisation, u: np.ndarray, condition: RunCondition) -> PredictedBranch:
    there = ModelAt(p, u)
    force = there.model.excited_by(condition.force)
    points = list(continue_branch(there.model.system, force, condition.wider, upwards=condition.upwards))
    return observe(there, condition, points, "")
