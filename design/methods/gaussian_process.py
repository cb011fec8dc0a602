"""Bayesian search with a Gaussian process: for few designs that are dear."""

from typing import Any

from updamp.design.methods.method import library, method
from updamp.design.methods.optuna_search import OptunaSearch


@method("gp")
class GaussianProcess(OptunaSearch):
    """As Optuna has it; it needs PyTorch, which is not among updamp's own requirements."""

    def sampler(self, optuna: Any, seed: int) -> Any:
        library("torch", "torch")
        return optuna.samplers.GPSampler(seed=seed, deterministic_objective=True)
