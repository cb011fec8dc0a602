"""What a fit would be worth, had another repeatability been stated, where no repeats tell how far a model may be off.

Parameters stay where they are: another noise for all points alike hardly moves them.
"""

from updamp.comparison.fit.compared import compare_at, misfit, predict_branches
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.prediction_error import PredictionError, of_compared
from updamp.comparison.prediction.branch_tasks import Branches, in_turn
from updamp.diagnosis.candidate_models.baseline import Baseline
from updamp.diagnosis.evidence import IfRepeatable

# Relative: from what a laboratory reaches in one sitting to what a joint does when it is taken apart.
REPEATABILITIES = (0.003, 0.005, 0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2)


def if_repeatable(fitted: Fit, start: Baseline, branches_of: Branches = in_turn) -> tuple[IfRepeatable, ...]:
    """One for each of `REPEATABILITIES`; none where repeats tell."""
    train, unseen = start.train_plan, start.held_out_plan
    if not start.plan.repeatability:
        return ()
    p, u, scatter = fitted.parametrisation, fitted.u, fitted.compared.scatter
    solved = fitted.compared.branches or predict_branches(p, u, train, None, branches_of)
    held = predict_branches(p, u, unseen, None, branches_of) if unseen.conditions else ()
    found = []
    for repeatability in REPEATABILITIES:
        one = compare_at(p, u, train.if_repeatable(repeatability), solved, scatter, fitted.compared.offsets)
        held_out = PredictionError()
        if held:
            other = compare_at(p, u, unseen.if_repeatable(repeatability), held, scatter)
            held_out = of_compared(other, fitted)
        found.append(
            IfRepeatable(repeatability, one.mean_squared_misfit, misfit(p, one), held_out.error, held_out.misfit)
        )
    return tuple(found)
