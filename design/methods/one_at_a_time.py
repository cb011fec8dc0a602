"""One variable at a time, the others at their initial values."""

from typing import Annotated

import numpy as np
from pydantic import Field

from updamp.design.methods.method import Evaluate, Method, MethodResult, Problem, method


@method("one_at_a_time")
class OneAtATime(Method):
    """points: of each variable, evenly from bound to bound; the initial design comes first"""

    points: Annotated[int, Field(strict=True, ge=2)] = 5

    def run(self, problem: Problem, evaluate: Evaluate) -> MethodResult:
        initial = problem.initial()
        designs = [initial]
        for one in problem.variables:
            designs += [{**initial, one.name: one.at(share)} for share in np.linspace(0, 1, self.points)]
        evaluate(designs, len(designs))
        return MethodResult()
