"""The numerical gate once more, for a model with an effect in it.

What a finer mesh would change is found for the model without effects. An effect may have a numerical error of its own:
where it lets the contacts at the ends of a face slip early, how many elements there are at the ends decides how early.
So a fit that explains most of a misfit, and still leaves more than the scatter, is compared with finer models that have
the effect too.
"""

from dataclasses import replace

import numpy as np

from updamp.diagnosis.model.numerical_error import NumericalError
from updamp.diagnosis.model.predicted_branch import with_patterns
from updamp.diagnosis.residual.fit import Fit, FitOptions, fit, predict
from updamp.diagnosis.residual.numerical_gate import finer_than, with_numerical_error
from updamp.diagnosis.search.baseline import Baseline


def gated_again(found: Fit, start: Baseline, options: FitOptions) -> Fit:
    """The fit gone on with the numerical error of its own model.

    raises: BranchStoppedError where a finer model has no response at the beginning of a run
    """
    p = found.parametrisation
    plain = replace(p, numerics=NumericalError())
    at = found.u[: len(plain)]
    branches = predict(plain, at, start.plan)
    gated = with_numerical_error(plain, at, start.plan, branches, finer_than(p.base, start.finer))
    u = np.append(at, np.zeros(len(gated) - len(plain)))
    at_start = [with_patterns(branches[i], gated.numerics) for i in start.training]
    return fit(gated, start.train_plan, u, found.compared.scatter, at_start, options)
