"""Bars: how much each response depends on each variable."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.stats import spearmanr

from updamp.design.methods.method import Sensitivity
from updamp.design.run_study import StudyResult
from updamp.report.markup import LEVELS

_FEWEST = 6  # designs, for a correlation to say anything


def sensitivity_figures(result: StudyResult) -> dict[str, Any]:
    """name -> plotly figure; those of the method, or rank correlations over all designs where it has none"""
    found = result.method.sensitivities if result.method else ()
    found = found or rank_correlations(result)
    responses = dict.fromkeys(one.response for one in found)
    return {f"sensitivity-{name}": _bars(name, [one for one in found if one.response == name]) for name in responses}


def rank_correlations(result: StudyResult) -> tuple[Sensitivity, ...]:
    """Spearman's, of each response with each variable, over the designs where it is known."""
    found = []
    for response in result.study.responses:
        known = [one for one in result.records if one.responses.get(response.name) is not None]
        values = np.array([one.responses[response.name] for one in known], float)
        if len(known) < _FEWEST or np.ptp(values) <= 1e-12 * np.abs(values).max():
            continue
        for variable in result.study.variables:
            places = np.array([one.values[variable.name] for one in known])
            if np.ptp(places) > 0:
                value = float(spearmanr(places, values).statistic)
                found.append(Sensitivity(response.name, variable.name, "rank correlation", value, 0.0))
    return tuple(found)


def _bars(response: str, found: Sequence[Sensitivity]) -> dict[str, Any]:
    measures = list(dict.fromkeys(one.measure for one in found))
    traces = []
    for i, measure in enumerate(measures):
        own = [one for one in found if one.measure == measure]
        trace: dict[str, Any] = {
            "type": "bar", "name": measure, "x": [one.variable for one in own], "y": [one.value for one in own],
            "marker": {"color": LEVELS[i % len(LEVELS)]},
        }  # fmt: skip
        if any(one.confidence for one in own):
            trace["error_y"] = {"type": "data", "array": [one.confidence for one in own]}
        traces.append(trace)
    layout = {
        "title": {"text": f"{response}: {', '.join(measures)}"}, "barmode": "group",
        "showlegend": len(measures) > 1, "yaxis": {"zeroline": True},
    }  # fmt: skip
    return {"data": traces, "layout": layout}
