"""What both sensitivity methods of SALib share: blocks of designs that are known or left out together."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from updamp.design.methods.method import MethodResult, Problem, Sensitivity
from updamp.design.records import Record

Floats = NDArray[np.float64]
Analysis = Callable[[Floats, Floats], Mapping[str, tuple[Floats, Floats]]]
"""From designs (n, n_variables) and one response (n,) to measure -> values and confidences (n_variables,)"""


def salib_problem(problem: Problem) -> dict[str, object]:
    """Variables by their shares of the ranges."""
    names = [one.name for one in problem.variables]
    return {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}


def analysed(
    problem: Problem, shares: Floats, records: Sequence[Record], block: int, analysis: Analysis
) -> MethodResult:
    """block: designs that a method needs together; where one of them is not known, all of them are left out"""
    found: list[Sensitivity] = []
    notes: list[str] = []
    for response in problem.responses:
        values = [record.responses.get(response) for record in records]
        known = np.array([np.nan if value is None else value for value in values], float).reshape(-1, block)
        whole = np.isfinite(known).all(axis=1)
        if not whole.all():
            notes.append(f"{response}: {(~whole).sum()} of {len(whole)} blocks of designs are left out: not all known")
        if whole.sum() < 2 or np.ptp(known[whole]) <= 1e-12 * np.abs(known[whole]).max():
            notes.append(
                f"{response}: no sensitivities, since it {'is constant' if whole.sum() > 1 else 'is not known'}"
            )
            continue
        designs = shares.reshape(-1, block, shares.shape[1])[whole].reshape(-1, shares.shape[1])
        for measure, (size, confidence) in analysis(designs, known[whole].ravel()).items():
            notes += _not_told(response, measure, problem, size, confidence)
            for one, value, width in zip(problem.variables, size, confidence, strict=True):
                found.append(Sensitivity(response, one.name, measure, _plain(value), _plain(width)))
    return MethodResult(tuple(found), {"designs": len(records)}, tuple(notes))


def _not_told(response: str, measure: str, problem: Problem, size: Floats, confidence: Floats) -> list[str]:
    """Where even the largest is not told from none: the samples are too few for the rest too."""
    largest = int(np.nanargmax(size)) if np.isfinite(size).any() else 0
    if not 0 < confidence[largest] >= size[largest]:
        return []
    value = f"{measure} = {size[largest]:.2g} ± {confidence[largest]:.2g}"
    name = problem.variables[largest].name
    return [f"{response}: {value} of {name}, the largest, may as well be 0; more samples are needed"]


def _plain(value: float) -> float:
    return float(value) if np.isfinite(value) else 0.0
