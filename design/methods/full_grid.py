"""All combinations of evenly spaced values."""

from itertools import product
from typing import Annotated

import numpy as np
from pydantic import Field

from updamp.design.methods.method import Evaluate, Method, MethodResult, Problem, method


@method("grid")
class FullGrid(Method):
    """points: of each variable; so many to the power of the number of variables are solved"""

    points: Annotated[int, Field(strict=True, ge=2)] = 3

    def run(self, problem: Problem, evaluate: Evaluate) -> MethodResult:
        steps = np.linspace(0, 1, self.points)
        designs = [problem.values(shares) for shares in product(steps, repeat=len(problem.variables))]
        evaluate(designs, len(designs))
        return MethodResult()
