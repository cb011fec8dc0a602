"""Tree-structured Parzen estimator: a good first choice, for up to some ten variables and hundreds of designs."""

from typing import Any

from updamp.design.methods.method import method
from updamp.design.methods.optuna_search import OptunaSearch


@method("tpe")
class Tpe(OptunaSearch):
    """Bergstra et al. (2011), as Optuna has it."""

    def sampler(self, optuna: Any, seed: int) -> Any:
        return optuna.samplers.TPESampler(seed=seed)
