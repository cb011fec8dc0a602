"""Pieces of HTML, numbers as an engineer writes them, in which units they are drawn, and the colours of the report."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape

from updamp.comparison.comparison import Comparison

# Colours that the colour-blind can tell apart: Okabe and Ito (2008), "Color Universal Design".

BLUE, VERMILLION, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#CC79A7"
ORANGE, SKY, BLACK, GREY = "#E69F00", "#56B4E9", "#1a1a1a", "#8a8f98"

LEVELS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK)  # in turn, where force levels are drawn together

# Dark to light, evenly: viridis (van der Walt and Smith 2015) short of its yellow, for more levels than that.
MANY_LEVELS = ("#440154", "#414487", "#2a788e", "#22a884", "#7ad151", "#d8b500")

MEASURED, BEFORE, AFTER, BAND = BLACK, VERMILLION, BLUE, "rgba(138,143,152,0.30)"
FOR_SCRIPTS = {
    "levels": LEVELS,
    "many": MANY_LEVELS,
    "measured": MEASURED,
    "before": BEFORE,
    "after": AFTER,
    "band": BAND,
}

# From 1 on, what scatter does not explain; evenly spaced in the logarithm from 1/2 to 2, and from there to
# the largest.
RESIDUAL_SCALE = (
    (0, "#f4f5f7"),
    (1 / 6, "#e3e6ea"),
    (1 / 3, "#f6d9a8"),
    (0.5, "#E69F00"),
    (0.75, "#D55E00"),
    (1, "#6b1d00"),
)
# White in the middle: cosines, signatures.
TWO_SIDED_SCALE = ((0, VERMILLION), (0.5, "#ffffff"), (1, BLUE))

MISSING = "\N{EN DASH}"
MINUS = "\N{MINUS SIGN}"
TIMES = "\N{MULTIPLICATION SIGN}"


def figure_element(name: str, description: str, caption: str = "", height: int = 420) -> str:
    """Place of a plot, which scripts call by its name.

    description: what it shows, for those who cannot see it; caption: below it; height [px]
    """
    below = f"<figcaption>{caption}</figcaption>" if caption else ""
    return (
        f'<figure><div class="plot" id="plot-{escape(name)}" role="img" aria-label="{escape(description)}" '
        f'style="height:{height}px"></div>{below}</figure>'
    )


def table(head: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "", numbers_from: int = 1) -> str:
    """head, rows: HTML already; numbers_from: column from which on cells hold numbers, set to the right"""

    def cell(tag: str, i: int, content: str) -> str:
        kind = ' class="number"' if i >= numbers_from else ""
        scope = ' scope="col"' if tag == "th" else ""
        return f"<{tag}{kind}{scope}>{content}</{tag}>"

    top = "".join(cell("th", i, content) for i, content in enumerate(head))
    body = "".join("<tr>" + "".join(cell("td", i, content) for i, content in enumerate(row)) + "</tr>" for row in rows)
    above = f"<caption>{caption}</caption>" if caption else ""
    return f'<div class="table"><table>{above}<thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>'


def paragraph(text: str, kind: str = "") -> str:
    """text: plain"""
    mark = f' class="{kind}"' if kind else ""
    return f"<p{mark}>{escape(text)}</p>"


def number(value: float, digits: int = 4) -> str:
    """At most 4 significant digits, powers of ten where the number is long; a dash for nan"""
    if math.isnan(value):
        return MISSING
    if math.isinf(value):
        return "∞" if value > 0 else f"{MINUS}∞"
    if value == 0:
        return "0"
    power = math.floor(math.log10(abs(value)))
    if -4 <= power < 6:
        text = _exact(f"{value:.{max(digits - 1 - power, 0)}f}", value)
    else:
        text = f"{_exact(f'{value / 10**power:.{digits - 1}f}', value / 10**power)} {TIMES} 10{_raised(power)}"
    return text.replace("-", MINUS)


def percent(relative: float, digits: int = 2) -> str:
    """With its sign; a dash for nan"""
    if not math.isfinite(relative):
        return number(relative)
    value = 100 * relative
    places = max(digits - 1 - math.floor(math.log10(abs(value))), 0) if value else 0
    return f"{value:+.{min(places, 4)}f} %".replace("-", MINUS)


def with_unit(value: float, unit: str) -> str:
    text = number(value)
    return f"{text} {escape(pretty(unit))}" if unit and text != MISSING else text


def bar(share: float) -> str:
    """Drawn beside a number. share: of its full width, 0 to 1"""
    width = 100 * min(max(share, 0.0), 1.0) if math.isfinite(share) else 0.0
    return f'<span class="bar"><span style="width:{width:.1f}%"></span></span>'


def level_name(level: float, unit: str = "N") -> str:
    """To three digits: a level is what was aimed at, held to a few per mille"""
    return f"{float(f'{level:.3g}'):g} {escape(pretty(unit))}"


def level_word(comparison: Comparison) -> str:
    """What its levels are called."""
    return "force level" if comparison.level_unit == comparison.force_unit else "response level"


@dataclass(frozen=True)
class DrawnUnits:
    """Of amplitudes: micrometres and mm/N, or those that the channels have where they are not calibrated.

    displacement, receptance: unit, and what numbers in m and m/N are multiplied by; stiffness, damping: units
    """

    displacement: tuple[str, float] = ("µm", 1e6)
    receptance: tuple[str, float] = ("mm/N", 1e3)
    stiffness: str = "N/m"
    damping: str = "N s/m"


def drawn_units(comparison: Comparison) -> DrawnUnits:
    response, force = comparison.response_unit, comparison.force_unit
    if (response, force) == ("m", "N"):
        return DrawnUnits()
    return DrawnUnits((response, 1.0), (f"{response}/{force}", 1.0), f"{force}/{response}", f"{force} s/{response}")


def _exact(text: str, value: float) -> str:
    """393 Hz was not stated to four digits, so it is not written with them."""
    return text.rstrip("0").rstrip(".") if "." in text and math.isclose(float(text), value, rel_tol=1e-12) else text


def _raised(power: int) -> str:
    return "".join("⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".index(digit)] for digit in str(power))


def pretty(unit: str) -> str:
    return unit.replace("**", "^").replace("^2", "²").replace("^3", "³").replace("*", "·").replace("degree", "°")
