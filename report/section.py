"""What a section of the report is.

A new one is a file in `sections/` with its `SECTION`, and a line in `registry.py`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from updamp.comparison.comparison import Comparison
from updamp.diagnosis.verdict import Verdict


@dataclass(frozen=True)
class Report:
    """What sections draw from. verdict: of the diagnosis, None in a report of the comparison alone

    pictures: caption -> PNG
    """

    comparison: Comparison
    verdict: Verdict | None = None
    pictures: Mapping[str, bytes] = field(default_factory=dict)


@dataclass(frozen=True)
class Content:
    """html: below the heading; a picture is an element made by `markup.figure_element`

    figures: name -> plotly's {"data": ..., "layout": ...}, drawn into the element of that name as they are
    data: what the section's scripts read as `updamp.data[identifier]`; arrays may be numpy's
    scripts: names of files in `assets/`, run in this order after the page is there
    """

    html: str
    figures: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    data: Mapping[str, Any] = field(default_factory=dict)
    scripts: tuple[str, ...] = ()


@dataclass(frozen=True)
class ReportSection:
    """identifier: a word, for links; title: its heading; render: None where there is nothing to show

    short: its name in the list of contents, where the heading is too long for it
    """

    identifier: str
    title: str
    render: Callable[[Report], Content | None]
    short: str = ""
