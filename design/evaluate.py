"""From a design to its record: every response, or the reason why there is none. Runs in any process."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from updamp.design.records import BROKEN, DONE, FAILED, PARTLY, Record
from updamp.design.responses.response import Response
from updamp.design.solved_design import DesignInput, SolvedDesign
from updamp.design.solved_peak import CURVE, PeakRequest
from updamp.design.variables import Values

# What the rooms below raise with a sentence: a geometry that cannot be built, a solver that stops, a missing mode.
_EXPECTED = (ValueError, RuntimeError, ArithmeticError, np.linalg.LinAlgError)


@dataclass(frozen=True)
class Task:
    """What all designs of a study share. given: with no changes yet; setup: its hash, for the records"""

    given: DesignInput
    responses: tuple[Response, ...]
    setup: str


@dataclass(frozen=True)
class Asked:
    """One design. values: of the variables; changes: the same as a rig file has them; key: for its record"""

    values: Values
    changes: Mapping[str, Any]
    key: str


def evaluate(task: Task, asked: Asked) -> Record:
    """raises: nothing but KeyboardInterrupt and want of memory"""
    started = time.perf_counter()
    design = SolvedDesign(replace(task.given, changes=asked.changes))
    found: dict[str, float | None] = {}
    unknown: dict[str, str] = {}
    broken = False
    for response in task.responses:
        try:
            found[response.name] = _finite(response.value(design))
        except _EXPECTED as error:
            found[response.name], unknown[response.name] = None, _sentence(error)
        except Exception as error:
            found[response.name], unknown[response.name] = None, f"{type(error).__name__}: {error}"
            broken = True
    reasons = set(unknown.values())
    return Record(
        key=asked.key,
        setup=task.setup,
        values=dict(asked.values),
        outcome=BROKEN if broken else _outcome(found, unknown),
        responses=found,
        reason="; ".join(sorted(reasons)),
        unknown=unknown,
        routes={_name(request): how for request, how in design.routes.items()},
        executed=tuple(design.executed),
        seconds=round(time.perf_counter() - started, 3),
    )


def _outcome(found: Mapping[str, float | None], unknown: Mapping[str, str]) -> str:
    if not unknown:
        return DONE
    return FAILED if len(unknown) == len(found) else PARTLY


def _finite(value: float) -> float:
    if not np.isfinite(value):
        raise ValueError(f"the value is {value}")
    return float(value)


def _sentence(error: Exception) -> str:
    """The name of the file in front of a rig's problems is the same for all designs."""
    lines = [line for line in str(error).splitlines() if not line.endswith(".toml:")]
    return "; ".join(lines) or type(error).__name__


def _name(request: PeakRequest) -> str:
    place = f" at {request.point}" if request.point else ""
    return f"{request.mode} {request.force:g} N{place}{', whole curve' if request.by == CURVE else ''}"
