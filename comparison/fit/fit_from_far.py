"""Fits of models without contacts, whose curves may jump, from wherever the rig file stands.

Beside a jump a measured point has nothing near it on the model's curve at its frequency, and where a resonance is off
by several widths no derivative leads there. So frequency counts as one more quantity that was measured (errors in all
variables), at first with a standard deviation of a good part of the measured range: then curves are compared as shapes
in frequency, amplitude and phase, which meet whatever their jumps. It falls from stage to stage to the instrument's
(a homotopy). Until the last stage the model is taken to lack nothing: with the noise inflated by its misfit, priors
would hold it where it fails, and a misfit that grows hardly counts, so there are many places to get stuck at. The last
stage alone decides, with what the model lacks as noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.compared import compare_at, objective, predict_branches
from updamp.comparison.fit.fit import Fit, FitOptions, Progress, fit
from updamp.comparison.fit.fit_round import prior_scatter
from updamp.comparison.fit.observations import Observations, Plan
from updamp.comparison.fit.scatter import Scatter
from updamp.comparison.prediction.branch_tasks import Branches, in_turn
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class StageOptions:
    """first: standard deviation of the frequencies in the first stage, over the range that a run was measured in: a
        resonance is a few tenths of it wide, and as far off at most, or its test would have missed it
    narrower: what it is divided by from stage to stage. Three suffice: in the second a resonance is known to less than
        what an amplitude's noise makes of it, and jumps alone are left to settle
    """

    first: float = 0.1
    narrower: float = 32.0


_STAGE = FitOptions(rounds=8, largest_step=1.0, share=0.02, retraced=False)
# Half of what a parameter costs that is one standard deviation off.
LAST = FitOptions(largest_step=1.0, tolerance=0.5)


def fit_from_far(
    parametrisation: Parametrisation,
    plan: Plan,
    start: Floats,
    scatter: Scatter | None = None,
    at_start: Sequence[PredictedBranch] | None = None,
    progress: Progress = lambda _: None,
    branches_of: Branches = in_turn,
) -> Fit:
    """As `fit`, with stages before it. Where they end worse than the model at `start`, without them.

    raises: BranchStoppedError where the model has no response to compare at the start
    """
    u, branches = start, at_start
    stated = scatter or prior_scatter(parametrisation, plan)
    for width in _widths(plan):
        found = fit(parametrisation, _widened(plan, width), u, stated, branches, _STAGE, progress, branches_of)
        u, branches = found.u, found.compared.branches if _solved_there(found) else None
    last = fit(parametrisation, plan, u, scatter, branches, LAST, progress, branches_of)
    solved = at_start or predict_branches(parametrisation, start, plan, None, branches_of)
    before = compare_at(parametrisation, start, plan, solved, last.compared.scatter)
    if objective(parametrisation, last.compared) <= objective(parametrisation, before):
        return last
    return fit(parametrisation, plan, start, scatter, solved, LAST, progress, branches_of)


def _solved_there(found: Fit) -> bool:
    return all(np.array_equal(branch.u, found.u) for branch in found.compared.branches)


def _widths(plan: Plan) -> list[float]:
    """Shares of the range measured, as long as they count more than the instrument."""
    widest = max(_range(o) / float(np.median(o.noise[:, 0])) for o in plan.observations)
    number = int(np.ceil(np.log(StageOptions.first * widest) / np.log(StageOptions.narrower)))
    return [StageOptions.first / StageOptions.narrower**i for i in range(max(number, 0))]


def _range(run: Observations) -> float:
    """Of the logarithm of the frequency."""
    return float(np.ptp(run.observed[:, 0]))


def _widened(plan: Plan, width: float) -> Plan:
    """With frequencies known to a share of the range that their run was measured in, every point counting."""
    runs = []
    for run in plan.observations:
        noise = run.own.copy()
        noise[:, 0] = np.hypot(noise[:, 0], width * _range(run))
        runs.append(replace(run, own=noise))
    return replace(plan, observations=tuple(runs), lacks_nothing=True)
