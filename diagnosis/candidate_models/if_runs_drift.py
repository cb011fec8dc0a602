"""Whether a model would describe the data, had every run a resonance of its own.

A structure that warms up, or a clamp that settles, moves the resonance between runs by more than the drift that is
stated, at whatever level comes next. No effect does: what depends on the level alone is the same whenever it is run.
"""

from dataclasses import replace

import numpy as np

from updamp.comparison.fit.fit import fit
from updamp.comparison.fit.prediction_error import prediction_error
from updamp.comparison.prediction.branch_tasks import Branches, in_turn
from updamp.diagnosis.candidate_models.baseline import Baseline
from updamp.diagnosis.evidence import IfRunsDrift

# Relative deviation of a run's resonance that leaves it free: far more than what warming (some 2e-4 a degree of steel)
# and a clamp that settles do to a test in one sitting.
_FREE = 0.01
# Runs of which the spread of a resonance says anything.
_FEWEST = 3


def if_runs_drift(start: Baseline, branches_of: Branches = in_turn) -> IfRunsDrift | None:
    """The calibration once more with every run's resonance free; none where repeats tell the drift, or of few runs.

    raises: BranchStoppedError where the model has no response at the beginning of a run
    """
    base, plan = start.fitted, start.train_plan
    if len(start.plan.repeats) > 1 or len(plan.conditions) < _FEWEST:
        return None
    scatter = replace(base.compared.scatter, drift=_FREE)
    found = fit(base.parametrisation, plan, base.u, scatter, branches_of=branches_of)
    (offsets,) = found.compared.offsets.values()
    drift = float(np.std(list(offsets.drift.values()), ddof=1))
    predicted = prediction_error(found, start.held_out_plan, branches_of)
    return IfRunsDrift(drift, found.compared.mean_squared_misfit, predicted.misfit)
