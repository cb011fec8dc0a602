"""Latin hypercube: each variable's range in as many strips as there are samples, one sample in each."""

from typing import Annotated

import numpy as np
from pydantic import Field
from scipy.stats import qmc

from updamp.design.methods.method import Evaluate, Method, MethodResult, Problem, method
from updamp.design.methods.sobol import Seed


@method("latin_hypercube")
class LatinHypercube(Method):
    """samples: how many; with another number all are other ones"""

    samples: Annotated[int, Field(strict=True, ge=2)] = 32
    seed: Seed = 1

    def run(self, problem: Problem, evaluate: Evaluate) -> MethodResult:
        cube = qmc.LatinHypercube(len(problem.variables), rng=np.random.default_rng(self.seed))
        designs = [problem.values(shares) for shares in cube.random(self.samples)]
        evaluate(designs, len(designs))
        return MethodResult()
