"""Force loops of named contacts: tangential force over relative displacement, and forces over a period."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from updamp.model.force_loops import ForceLoop
from updamp.pictures.faces import STATES
from updamp.pictures.style import BLUE, GREY, LIGHT_GREY, VERMILLION, figure

ACROSS = 3  # contacts in a row


def force_loops(path: Path, title: str, loops: Sequence[ForceLoop]) -> None:
    """Two axes a contact: the loop; beside it the tangential force between its limits, and the normal force."""
    rows = -(-len(loops) // ACROSS)
    with figure(path, 14.0, 0.8 + 2.5 * rows) as drawing:
        axes = drawing.subplots(rows, 2 * ACROSS, squeeze=False)
        for ax in axes.ravel()[2 * len(loops) :]:
            ax.set_visible(False)
        for loop, (left, right) in zip(loops, axes.reshape(-1, 2), strict=False):
            _loop(left, loop)
            _histories(right, loop)
        drawing.legend(*axes[0, 1].get_legend_handles_labels(), loc="outside lower center", ncols=2)
        drawing.suptitle(title, fontweight="bold", x=0.01, ha="left")


def _loop(ax: Axes, loop: ForceLoop) -> None:
    closed = np.append(np.arange(len(loop.motion)), 0)
    ax.plot(1e6 * loop.motion[closed, 0], loop.force[closed, 0], color=BLUE, linewidth=1.3)
    ax.set_title(f"{loop.name}: {list(STATES)[loop.state]}", fontsize=9)
    ax.set_xlabel("displacement up the slope [µm]", fontsize=8)
    ax.set_ylabel("tangential force [N]", fontsize=8)
    ax.locator_params(axis="x", nbins=3)  # more of them collide
    ax.tick_params(labelsize=7)


def _histories(ax: Axes, loop: ForceLoop) -> None:
    phase = 360 * np.arange(len(loop.motion)) / len(loop.motion)
    limit = loop.mu * loop.normal
    ax.fill_between(phase, -limit, limit, color=LIGHT_GREY, alpha=0.6, linewidth=0)
    ax.plot(phase, loop.force[:, 0], color=BLUE, linewidth=1.2, label="tangential")
    ax.plot(phase, loop.normal, color=VERMILLION, linewidth=1.2, label="normal")
    ax.axhline(0, color=GREY, linewidth=0.6)
    ax.set_xlabel("phase [degrees]", fontsize=8)
    ax.set_ylabel("force [N]", fontsize=8)
    ax.set(xlim=(0, 360), xticks=range(0, 361, 90))
    ax.tick_params(labelsize=7)
