"""What a method is, the register of those that a study file can name, and the libraries that some of them need."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from updamp.design.goals import Constraint, Objective
from updamp.design.records import Record
from updamp.design.variables import Values, Variable
from updamp.rig.fields import InputTable


@dataclass(frozen=True)
class Problem:
    """What a method knows of a study. folder: for what a method keeps between sessions; key: of what that belongs to;
    responses: names"""

    name: str
    variables: tuple[Variable, ...]
    responses: tuple[str, ...]
    objectives: tuple[Objective, ...]
    constraints: tuple[Constraint, ...]
    folder: Path
    key: str = ""

    def values(self, shares: Sequence[float] | NDArray[np.float64]) -> dict[str, float]:
        """A design by its shares of the ranges, each 0 to 1, in the order of the variables."""
        return {one.name: one.at(share) for one, share in zip(self.variables, shares, strict=True)}

    def initial(self) -> dict[str, float]:
        return {one.name: one.initial for one in self.variables}

    def losses(self, record: Record) -> tuple[float, ...] | None:
        """One an objective, smaller is better; None where one of the responses is not known."""
        values = [record.responses.get(one.response) for one in self.objectives]
        if any(value is None for value in values):
            return None
        return tuple(one.goal.loss(float(v)) for one, v in zip(self.objectives, values, strict=True) if v is not None)

    def violations(self, record: Record) -> tuple[float, ...] | None:
        """One a constraint, 0 or less where it is kept; None where one of the responses is not known."""
        values = [record.responses.get(one.response) for one in self.constraints]
        if any(value is None for value in values):
            return None
        return tuple(one.violation(float(v)) for one, v in zip(self.constraints, values, strict=True) if v is not None)


class Evaluate(Protocol):
    """Solves designs, several at a time; one that was solved before is taken from its record."""

    def __call__(self, designs: Sequence[Values], expected: int | None = None) -> list[Record]:
        """expected: how many there will be in all, for the progress bar; returns: in the order of `designs`"""
        ...


@dataclass(frozen=True)
class Sensitivity:
    """measure: such as "S1", "ST" (shares of the variance), "mu_star", "sigma"; confidence: half the width of the 95 %
    interval"""

    response: str
    variable: str
    measure: str
    value: float
    confidence: float


@dataclass(frozen=True)
class MethodResult:
    """What a method says beside the designs. summary: of a fit or a search, as it goes into study.json
    notes: sentences for the terminal and the page
    draws: of a posterior, variable -> (n,) equally probable values; none where the method draws none"""

    sensitivities: tuple[Sensitivity, ...] = ()
    summary: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    draws: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)


class Method(InputTable):
    """The [method] of a study file, `kind` aside; its options are the fields of its class."""

    def problem(self, variables: Sequence[Variable], objectives: Sequence[Objective]) -> str:  # noqa: ARG002
        """Why it cannot be used with these, "" where it can."""
        return ""

    def run(self, problem: Problem, evaluate: Evaluate) -> MethodResult:
        """raises: what `evaluate` raises; ValueError with a sentence where it cannot go on"""
        raise NotImplementedError


METHODS: dict[str, type[Method]] = {}
"""kind -> class; filled by the files of this folder, which `design/study_file.py` imports."""

Kind = TypeVar("Kind", bound=type[Method])


def method(kind: str) -> Callable[[Kind], Kind]:
    """Register a class under the name that a study file uses for it."""

    def add(cls: Kind) -> Kind:
        METHODS[kind] = cls
        return cls

    return add


def library(name: str, package: str = "'updamp[design]'") -> Any:
    """A module of the extra "design", loaded by who asks for it: they take a second each, and need not be there.

    package: that pip installs it with; raises: ValueError with what to install
    """
    try:
        return import_module(name)
    except ImportError as error:
        raise ValueError(f"{name.partition('.')[0]} is not installed; get it with `pip install {package}`") from error
