"""Sobol's sequence: points that fill the box evenly however many are taken, and more of them later."""

from typing import Annotated

import numpy as np
from pydantic import AfterValidator, Field
from scipy.stats import qmc

from updamp.design.methods.method import Evaluate, Method, MethodResult, Problem, method


def power_of_two(samples: int) -> int:
    """raises: ValueError naming the two nearest"""
    if samples & (samples - 1):
        below = 1 << (samples.bit_length() - 1)
        raise ValueError(f"a power of 2 is wanted, such as {below} or {2 * below}")
    return samples


Samples = Annotated[int, Field(strict=True, ge=2, examples=[32]), AfterValidator(power_of_two)]
Seed = Annotated[int, Field(strict=True, ge=0)]


@method("sobol")
class Sobol(Method):
    """samples: a power of 2; with twice as many later, the first half is the same. seed: of the scrambling"""

    samples: Samples = 32
    seed: Seed = 1

    def run(self, problem: Problem, evaluate: Evaluate) -> MethodResult:
        sequence = qmc.Sobol(len(problem.variables), rng=np.random.default_rng(self.seed))
        designs = [problem.values(shares) for shares in sequence.random_base2(self.samples.bit_length() - 1)]
        evaluate(designs, len(designs))
        return MethodResult()
