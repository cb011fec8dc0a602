"""The designs that no other one beats: the best one of a single objective, the Pareto front of several."""

from collections.abc import Sequence

import numpy as np

from updamp.design.methods.method import Problem
from updamp.design.records import Record


def best_records(problem: Problem, records: Sequence[Record]) -> tuple[Record, ...]:
    """Of those that keep all constraints, the ones that none other surpasses in an objective without being worse in
    another; by the first objective, best first. None where the study has no objective."""
    if not problem.objectives:
        return ()
    judged = [(record, problem.losses(record), problem.violations(record)) for record in records]
    kept = [(r, losses) for r, losses, v in judged if losses is not None and v is not None and max(v, default=0.0) <= 0]
    if not kept:
        return ()
    losses = np.array([found for _, found in kept])
    best = [i for i, own in enumerate(losses) if not ((losses <= own).all(axis=1) & (losses < own).any(axis=1)).any()]
    return tuple(kept[i][0] for i in sorted(best, key=lambda i: tuple(losses[i])))
