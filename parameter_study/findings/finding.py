"""What a finding is, what checking it gives, and numbers as the findings' sentences have them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from updamp.parameter_study.solved_study import SolvedStudy, UnknownResultError


@dataclass(frozen=True)
class Measured:
    """updamp: what the study shows, a sentence with numbers; met: whether the finding holds
    numbers: what it was judged by, names with units"""

    updamp: str
    met: bool
    numbers: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Finding:
    """paper: what the paper says; seen_in: where; criterion: what counts as met; check: raises UnknownResultError where
    the study lacks a curve"""

    number: int
    paper: str
    seen_in: str
    criterion: str
    check: Callable[[SolvedStudy], Measured]


@dataclass(frozen=True)
class Checked:
    """met: None where it is not known, with the reason in `updamp`"""

    finding: Finding
    updamp: str
    met: bool | None
    numbers: Mapping[str, float]


def checked(finding: Finding, solved: SolvedStudy) -> Checked:
    try:
        found = finding.check(solved)
    except UnknownResultError as error:
        return Checked(finding, f"not known: {error}", None, {})
    return Checked(finding, found.updamp, bool(found.met), {name: float(v) for name, v in found.numbers.items()})


def percent(share: float, digits: int = 0) -> str:
    """A change, with its sign."""
    return f"{100 * share:+.{digits}f} %"


def share(value: float) -> str:
    return f"{100 * value:.0f} %"


def mm(receptance: float) -> str:
    """receptance: [m/N]"""
    return f"{1e3 * receptance:.5f}"
