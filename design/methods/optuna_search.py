"""Search with Optuna: designs are asked for a batch at a time, and the answers change what is asked for next.

Answered trials stand in `optuna.db` of the study's folder (SQLite), each written whole; the same command goes on from
there. A search asks in memory, so that what was asked for and not answered when a session ended leaves no trace: the
batch is asked for again. Which designs come does not depend on who solves them nor on interruptions: a batch is of a
stated size, follows from the batches before it, and each design has random numbers of its own.
"""

import math
from abc import abstractmethod
from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from updamp.design.goals import Objective
from updamp.design.methods.method import Evaluate, Method, MethodResult, Problem, library
from updamp.design.methods.sobol import Seed
from updamp.design.records import Record
from updamp.design.variables import Variable


class OptunaSearch(Method):
    """designs: in all, over all sessions; the initial design comes first. Objectives may be several.
    batch: designs that are asked for before any of them is answered"""

    designs: Annotated[int, Field(strict=True, ge=1)] = 50
    batch: Annotated[int, Field(strict=True, ge=1)] = 4
    seed: Seed = 1

    @abstractmethod
    def sampler(self, optuna: Any, seed: int) -> Any:
        """Of the library; seed: of one design, whose random numbers are not those of the designs before it."""

    def problem(self, variables: Sequence[Variable], objectives: Sequence[Objective]) -> str:  # noqa: ARG002
        return "" if objectives else "an optimiser needs an objective; add [[objectives]] with response and goal"

    def run(self, problem: Problem, evaluate: Evaluate) -> MethodResult:
        """raises: ValueError where Optuna is not installed; what `evaluate` raises"""
        optuna = library("optuna")
        optuna.logging.set_verbosity(optuna.logging.WARNING)
        answered = self._answered(optuna, problem)
        start = len(answered.trials) // self.batch * self.batch
        search = optuna.create_study(directions=_directions(problem))
        search.add_trials(answered.trials[:start])
        if not start:
            search.enqueue_trial(problem.initial())
        space = {one.name: _distribution(optuna, one) for one in problem.variables}
        for first in range(start, self.designs, self.batch):
            places = range(first, min(self.designs, first + self.batch))
            trials = [self._asked(optuna, search, space, place) for place in places]
            designs = [{name: float(trial.params[name]) for name in space} for trial in trials]
            for trial, record in zip(trials, evaluate(designs, self.designs), strict=True):
                _tell(optuna, search, problem, trial, record)
            answered.add_trials(search.trials[len(answered.trials) :])
        unknown = sum(trial.state == optuna.trial.TrialState.FAIL for trial in search.trials)
        return MethodResult(summary={"trials": len(search.trials), "not_known": unknown})

    def _answered(self, optuna: Any, problem: Problem) -> Any:
        """The study of all sessions; with other options than the number of designs it is another search."""
        options = self.model_dump_json(exclude={"designs"})
        return optuna.create_study(
            study_name=f"{type(self).__name__} {problem.key[:16]} {options}",
            storage=f"sqlite:///{problem.folder / 'optuna.db'}",
            directions=_directions(problem),
            load_if_exists=True,
        )

    def _asked(self, optuna: Any, search: Any, space: dict[str, Any], place: int) -> Any:
        """place: of the design, counted from the first one of all sessions"""
        seed = int(np.random.SeedSequence((self.seed, place)).generate_state(1)[0])
        search.sampler = self.sampler(optuna, seed)
        return search.ask(space)


def _directions(problem: Problem) -> list[str]:
    return ["minimize"] * len(problem.objectives)


def _distribution(optuna: Any, one: Variable) -> Any:
    if one.whole:
        return optuna.distributions.IntDistribution(math.ceil(one.lower), math.floor(one.upper), log=one.logarithmic)
    return optuna.distributions.FloatDistribution(one.lower, one.upper, log=one.logarithmic)


def _tell(optuna: Any, study: Any, problem: Problem, trial: Any, record: Record) -> None:
    """A design whose responses are not known counts as failed: the search goes elsewhere."""
    losses, violations = problem.losses(record), problem.violations(record)
    trial.set_user_attr("design", record.number)
    if losses is None or violations is None:
        study.tell(trial, state=optuna.trial.TrialState.FAIL)
        return
    for limit, violation in zip(problem.constraints, violations, strict=True):
        trial.set_constraint(limit.response, violation)
    study.tell(trial, list(losses))
