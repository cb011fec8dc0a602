"""Search with Optuna: designs are asked for a batch at a time, and the answers change what is asked for next.

Trials stand in `optuna.db` of the study's folder (SQLite); the same command goes on from there. What was asked for and
not answered when a session ended is asked for again. Which designs come does not depend on who solves them: a batch is
of a stated size and answered in the order in which it was asked for, and each design has random numbers of its own.
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

_ANSWERED = "design"  # attribute of a trial: number of its design


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
        study = self._study(optuna, problem)
        _ask_again(optuna, study)
        if not study.trials:
            study.enqueue_trial(problem.initial())
        space = {one.name: _distribution(optuna, one) for one in problem.variables}
        while (known := _answered(study)) < self.designs:
            ends = min(self.designs, known - known % self.batch + self.batch)
            trials = [self._asked(optuna, study, space, place) for place in range(known, ends)]
            designs = [{name: float(trial.params[name]) for name in space} for trial in trials]
            for trial, record in zip(trials, evaluate(designs, self.designs), strict=True):
                _tell(optuna, study, problem, trial, record)
        unknown = sum(trial.state == optuna.trial.TrialState.FAIL for trial in study.trials)
        return MethodResult(summary={"trials": len(study.trials), "not_known_or_asked_again": unknown})

    def _study(self, optuna: Any, problem: Problem) -> Any:
        storage = f"sqlite:///{problem.folder / 'optuna.db'}"
        return optuna.create_study(
            study_name=f"{type(self).__name__} {problem.key[:16]}",
            storage=storage,
            directions=["minimize"] * len(problem.objectives),
            load_if_exists=True,
        )

    def _asked(self, optuna: Any, study: Any, space: dict[str, Any], place: int) -> Any:
        """place: of the design, counted from the first one of all sessions"""
        seed = int(np.random.SeedSequence((self.seed, place)).generate_state(1)[0])
        study.sampler = self.sampler(optuna, seed)
        return study.ask(space)


def _distribution(optuna: Any, one: Variable) -> Any:
    if one.whole:
        return optuna.distributions.IntDistribution(math.ceil(one.lower), math.floor(one.upper), log=one.logarithmic)
    return optuna.distributions.FloatDistribution(one.lower, one.upper, log=one.logarithmic)


def _ask_again(optuna: Any, study: Any) -> None:
    """What a session that was ended has left without an answer."""
    for trial in study.get_trials(states=(optuna.trial.TrialState.RUNNING,)):
        study.tell(trial.number, state=optuna.trial.TrialState.FAIL)
        if trial.params:
            study.enqueue_trial(trial.params)


def _answered(study: Any) -> int:
    return sum(_ANSWERED in trial.user_attrs for trial in study.trials)


def _tell(optuna: Any, study: Any, problem: Problem, trial: Any, record: Record) -> None:
    """A design whose responses are not known counts as failed: the search goes elsewhere."""
    losses, violations = problem.losses(record), problem.violations(record)
    trial.set_user_attr(_ANSWERED, record.number)
    if losses is None or violations is None:
        study.tell(trial, state=optuna.trial.TrialState.FAIL)
        return
    for limit, violation in zip(problem.constraints, violations, strict=True):
        trial.set_constraint(limit.response, violation)
    study.tell(trial, list(losses))
