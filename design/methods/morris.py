"""Morris's elementary effects: which variables matter at all, with few designs."""

from collections.abc import Mapping
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from updamp.design.methods.method import Evaluate, Method, MethodResult, Problem, library, method
from updamp.design.methods.sensitivity_samples import analysed, salib_problem
from updamp.design.methods.sobol import Seed

Floats = NDArray[np.float64]


@method("morris")
class Morris(Method):
    """trajectories * (variables + 1) designs are solved. mu_star: mean size of the change from bound to bound, in the
    response's unit; sigma: its scatter, large where a variable acts unevenly or together with others"""

    trajectories: Annotated[int, Field(strict=True, ge=2)] = 10
    levels: Annotated[int, Field(strict=True, ge=4, multiple_of=2)] = 4
    seed: Seed = 1

    def run(self, problem: Problem, evaluate: Evaluate) -> MethodResult:
        """raises: ValueError where SALib is not installed; what `evaluate` raises"""
        sample, analyze = library("SALib.sample.morris").sample, library("SALib.analyze.morris").analyze
        stated = salib_problem(problem)
        shares = np.asarray(sample(stated, self.trajectories, num_levels=self.levels, seed=self.seed))
        records = evaluate([problem.values(one) for one in shares], len(shares))

        def analysis(designs: Floats, values: Floats) -> Mapping[str, tuple[Floats, Floats]]:
            found = analyze(stated, designs, values, num_levels=self.levels, seed=self.seed)
            nothing = np.zeros(len(problem.variables))
            mu_star, confidence = (np.asarray(found[name], float) for name in ("mu_star", "mu_star_conf"))
            return {"mu_star": (mu_star, confidence), "sigma": (np.asarray(found["sigma"], float), nothing)}

        return analysed(problem, shares, records, len(problem.variables) + 1, analysis)
