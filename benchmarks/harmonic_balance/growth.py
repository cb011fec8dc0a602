"""How the cost grows with the number of contacts and of harmonics, on the synthetic structure; one thread."""

from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.ticker import NullFormatter, ScalarFormatter

from updamp.benchmarks.harmonic_balance.measure import Cost, branch_cost, in_a_process
from updamp.benchmarks.harmonic_balance.synthetic import excitation, synthetic, window

CONTACTS = (20, 73, 146, 292, 584)
HIGHEST = (1, 2, 3, 5, 7, 9)  # harmonics 0 to this
MIDDLE = 146, 3  # contacts and highest harmonic while the other one grows
POINTS = 40


@dataclass(frozen=True)
class Growth:
    """Cost by number of contacts, and by the highest harmonic."""

    contacts: dict[int, Cost]
    harmonics: dict[int, Cost]


def cost(contacts: int, highest: int, points: int = POINTS) -> Cost:
    system = synthetic(contacts, tuple(range(highest + 1)))
    return branch_cost(system, excitation(system), window(system), repeats=7, max_points=points)


def growth(contacts: tuple[int, ...] = CONTACTS, highest: tuple[int, ...] = HIGHEST, points: int = POINTS) -> Growth:
    return Growth(
        {n: in_a_process(1, cost, n, MIDDLE[1], points) for n in contacts},
        {h: in_a_process(1, cost, MIDDLE[0], h, points) for h in highest},
    )


def draw(grown: Growth, path: Path) -> None:
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 4.2), sharey=True, layout="constrained")
    _lines(left, grown.contacts)
    left.set(xlabel="contacts", ylabel="processor time (median), s", title=f"harmonics 0-{MIDDLE[1]}")
    _lines(right, grown.harmonics)
    right.set(xlabel="highest harmonic", title=f"{MIDDLE[0]} contacts")
    left.legend(frameon=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=160)
    plt.close(figure)


def _lines(axes: Axes, costs: dict[int, Cost]) -> None:
    at = list(costs)
    axes.loglog(at, [c.point_s for c in costs.values()], "o-", color="tab:blue", label="converged point")
    axes.loglog(at, [c.evaluation_s for c in costs.values()], "s-", color="tab:orange", label="residual with Jacobian")
    axes.set_xticks(at)
    axes.xaxis.set_major_formatter(ScalarFormatter())
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.grid(which="both", alpha=0.25)
