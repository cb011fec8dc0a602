"""The designs as columns, for the page's scripts."""

from typing import Any

from updamp.design.pareto import best_records
from updamp.design.run_study import StudyResult
from updamp.design.table import feasible, problem_of


def designs_data(result: StudyResult) -> dict[str, Any]:
    """columns: name -> label and values (null where not known); first: names that are shown to begin with"""
    study, problem = result.study, problem_of(result.study)
    columns: dict[str, Any] = {}
    for variable in study.variables:
        values = [one.values[variable.name] for one in result.records]
        columns[variable.name] = {"label": variable.label, "values": values, "log": variable.logarithmic}
    for response in study.responses:
        label = f"{response.name} [{response.unit}]" if response.unit else response.name
        known = [one.responses.get(response.name) for one in result.records]
        columns[response.name] = {"label": label, "values": known, "log": False}
    best = {one.number for one in best_records(problem, result.records)}
    return {
        "columns": columns,
        "numbers": [one.number for one in result.records],
        "best": [one.number in best for one in result.records],
        "kept": [feasible(problem, one) is not False for one in result.records],
        "reasons": [one.reason for one in result.records],
        "first": _first(result),
    }


def _first(result: StudyResult) -> list[str]:
    """Two objectives against each other; else the first response against the first variable."""
    objectives = list(dict.fromkeys(one.response for one in result.study.objectives))
    if len(objectives) >= 2:
        return objectives[:2]
    return [result.study.variables[0].name, (objectives or [result.study.responses[0].name])[0]]
