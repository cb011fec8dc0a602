"""Sobol's indices: which share of a response's variance comes from a variable, alone (S1) and with the others (ST)."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from updamp.design.methods.method import Evaluate, Method, MethodResult, Problem, library, method
from updamp.design.methods.sensitivity_samples import analysed, salib_problem
from updamp.design.methods.sobol import Samples, Seed

Floats = NDArray[np.float64]


@method("sobol_indices")
class SobolIndices(Method):
    """samples: a power of 2; samples * (variables + 2) designs are solved (Saltelli et al. 2010, as SALib has it)"""

    samples: Samples = 64
    seed: Seed = 1

    def run(self, problem: Problem, evaluate: Evaluate) -> MethodResult:
        """raises: ValueError where SALib is not installed; what `evaluate` raises"""
        sample, analyze = library("SALib.sample.sobol").sample, library("SALib.analyze.sobol").analyze
        stated = salib_problem(problem)
        shares = np.asarray(sample(stated, self.samples, calc_second_order=False, seed=self.seed))
        records = evaluate([problem.values(one) for one in shares], len(shares))

        def analysis(_: Floats, values: Floats) -> Mapping[str, tuple[Floats, Floats]]:
            found = analyze(stated, values, calc_second_order=False, seed=self.seed)
            return {measure: (found[measure], found[f"{measure}_conf"]) for measure in ("S1", "ST")}

        return analysed(problem, shares, records, len(problem.variables) + 2, analysis)
