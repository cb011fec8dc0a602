"""Version 2 of the blind benchmark: easy, jumping and scarce tests; strengths, signs, seeds and order drawn from one
number, which is drawn itself once the code is frozen.

Cases are numbered in the order in which they are run, which is drawn too: the first so many of them are a fair sample.
"""

from collections.abc import Iterator, Sequence
from itertools import cycle, islice
from typing import Annotated, TypeVar

import numpy as np
import typer

from updamp.benchmarks.hidden_effects.cases import Case, Kind, chosen
from updamp.benchmarks.hidden_effects.kinds_of_test import KINDS_OF_TEST
from updamp.benchmarks.hidden_effects.version_1 import PAIRS, version_1
from updamp.benchmarks.virtual_rig.bench import STRENGTHS, Hidden
from updamp.benchmarks.virtual_rig.laboratory import HIDDEN
from updamp.effects.catalogue import CATALOGUE

Each = TypeVar("Each")
# Of each kind of test: single effects, effects outside the catalogue, pairs; of all together: nothing hidden.
SINGLES, OUTSIDE, PAIRED, NULLS = 24, 8, 8, 40
# Of the way from weak to strong: a pair's effects show beside each other.
LEAST_IN_PAIR = 0.5


def version_2(draw: int) -> tuple[Case, ...]:
    """160 cases. draw: the seed of all draws"""
    rng = np.random.default_rng(draw)
    wanted = [(test, kind, hidden) for test in KINDS_OF_TEST for kind, hidden in _something(rng)]
    wanted += [(test, "none", ()) for test in islice(cycle(KINDS_OF_TEST), NULLS)]
    seeds = rng.choice(10**6, size=len(wanted), replace=False).tolist()
    order = rng.permutation(len(wanted)).tolist()
    return tuple(
        Case(number, wanted[i][1], wanted[i][2], seeds[i], test=wanted[i][0]) for number, i in enumerate(order, 1)
    )


# The options that all commands choose by.
Only = Annotated[list[str] | None, typer.Option(help="case_012, a kind, a strength or an effect; repeatable")]
Draw = Annotated[int | None, typer.Option(help="version 2, drawn from this number; version 1 by default")]


def cases_of(draw: int | None) -> tuple[Case, ...]:
    """Of version 2 with this draw; of version 1 for None."""
    return version_1() if draw is None else version_2(draw)


def chosen_cases(draw: int | None, only: Sequence[str] | None) -> tuple[Case, ...]:
    """All, or those that are named. raises: typer.BadParameter naming what selects nothing"""
    try:
        return chosen(cases_of(draw), only or ())
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="--only") from None


def _something(rng: np.random.Generator) -> Iterator[tuple[Kind, tuple[Hidden, ...]]]:
    """Of one kind of test: all that has something hidden."""
    inside, outside = ([n for n, e in HIDDEN.items() if e.in_catalogue is known] for known in (True, False))
    yield from (("single", (drawn(name, rng),)) for name in _shuffled(inside, SINGLES, rng))
    yield from (("outside", (drawn(name, rng),)) for name in _shuffled(outside, OUTSIDE, rng))
    for pair in _shuffled(PAIRS, PAIRED, rng):
        yield "pair", tuple(drawn(text.partition(":")[0], rng, LEAST_IN_PAIR) for text in pair)


def _shuffled(some: Sequence[Each], n: int, rng: np.random.Generator) -> list[Each]:
    """n of them, each as often as any other or once more."""
    rounds = [some[i] for _ in range(-(-n // len(some))) for i in rng.permutation(len(some))]
    return rounds[:n]


def drawn(name: str, rng: np.random.Generator, least: float = 0.0) -> Hidden:
    """Anywhere between weak and strong, evenly in the logarithm; of either sign where the catalogue's effect has two.

    least: share of the way that it is at least
    """
    weak, strong = (HIDDEN[name].strengths[s] for s in (STRENGTHS[0], STRENGTHS[-1]))
    way = float(rng.uniform(least, 1.0))
    values = {q: _between(weak[q], strong[q], way) for q in weak}
    if name in CATALOGUE and CATALOGUE[name].has_two_signs and rng.random() < 0.5:
        values = _turned_round(name, values)
    return Hidden(name, values, STRENGTHS[min(int(3 * way), 2)])


def _between(weak: float, strong: float, way: float) -> float:
    return float(weak * (strong / weak) ** way)


def _turned_round(name: str, values: dict[str, float]) -> dict[str, float]:
    """As far from the null value on its other side, a factor by as much the other way; as it was where the catalogue
    has no such value."""
    found = dict(values)
    for q in CATALOGUE[name].parameters:
        if q.shape:
            continue
        other = 1 / values[q.name] if q.null == 1 else 2 * q.null - values[q.name]
        if not q.lower <= other <= q.upper:
            return values
        found[q.name] = other
    return found
