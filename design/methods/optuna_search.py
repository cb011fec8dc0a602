"""Search with Optuna: designs are asked for in turn, and each answer changes what is asked for next.

Trials stand in `optuna.db` of the study's folder (SQLite); the same command goes on from there. What was asked for and
not answered when a session ended is asked for again.
"""

import math
from abc import abstractmethod
from collections.abc import Sequence
from typing import Annotated, Any

from pydantic import Field

from updamp.design.goals import Objective
from updamp.design.methods.method import Evaluate, Method, MethodResult, Problem, library
from updamp.design.methods.sobol import Seed
from updamp.design.records import Record
from updamp.design.variables import Variable

_ANSWERED = "design"  # attribute of a trial: number of its design


class OptunaSearch(Method):
    """designs: in all, over all sessions; the initial design comes first. Objectives may be several."""

    designs: Annotated[int, Field(strict=True, ge=1)] = 50
    seed: Seed = 1

    @abstractmethod
    def sampler(self, optuna: Any, seed: int) -> Any:
        """Of the library; seed: another one in each session, or what came first would be asked for again."""

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
        while (left := self.designs - _answered(study)) > 0:
            trials = [study.ask(space) for _ in range(min(left, problem.at_once))]
            designs = [{name: float(trial.params[name]) for name in space} for trial in trials]
            for trial, record in zip(trials, evaluate(designs, self.designs), strict=True):
                _tell(optuna, study, problem, trial, record)
        unknown = sum(trial.state == optuna.trial.TrialState.FAIL for trial in study.trials)
        return MethodResult(summary={"trials": len(study.trials), "not_known_or_asked_again": unknown})

    def _study(self, optuna: Any, problem: Problem) -> Any:
        storage = f"sqlite:///{problem.folder / 'optuna.db'}"
        name = f"{type(self).__name__} {problem.key[:16]}"
        known = name in optuna.get_all_study_names(storage)
        before = len(optuna.load_study(study_name=name, storage=storage).trials) if known else 0
        return optuna.create_study(
            study_name=name,
            storage=storage,
            sampler=self.sampler(optuna, self.seed + before),
            directions=["minimize"] * len(problem.objectives),
            load_if_exists=True,
        )


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
