"""NSGA-II: a genetic algorithm for several objectives and many designs."""

from typing import Annotated, Any

from pydantic import Field

from updamp.design.methods.method import method
from updamp.design.methods.optuna_search import OptunaSearch


@method("nsga2")
class Nsga2(OptunaSearch):
    """Deb et al. (2002), as Optuna has it. population: designs of one generation"""

    population: Annotated[int, Field(strict=True, ge=2)] = 20

    def sampler(self, optuna: Any, seed: int) -> Any:
        return optuna.samplers.NSGAIISampler(population_size=self.population, seed=seed)
