"""Maps over the damper's two contact faces, patch by patch: pressure and contact states."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch
from numpy.typing import NDArray

from updamp.fem.static_contact.rest_state import StaticContact
from updamp.geometry.contact_elements import LEFT, RIGHT, ContactElements
from updamp.pictures.damper_section import draw_faces
from updamp.pictures.style import BLUE, INK, LIGHT_GREY, SEQUENTIAL, VERMILLION, YELLOW, figure
from updamp.rig.rig import Rig

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

ACROSS, COLUMN = 5, 1.9  # force levels beside each other, each so many inches wide
SIDES = {LEFT: "left face", RIGHT: "right face"}
# In the order of hbm.observe.ContactState.
STATES = {"stuck": BLUE, "stick-slip": YELLOW, "separating": VERMILLION, "never in contact": LIGHT_GREY}


def unrolled(contacts: ContactElements, side: int) -> Floats:
    """(n_side, 3, 2) corners of one face's patches: (place along the damper, height up the slope from its edge) [mm]"""
    on = contacts.face == side
    up = np.einsum("ecx,ex->ec", contacts.triangle[on], contacts.tangent1[on])
    along = np.einsum("ecx,ex->ec", contacts.triangle[on], contacts.tangent2[on])
    return 1e3 * np.stack([along, up - up.min()], axis=-1)


def pressure(path: Path, contacts: ContactElements, rest: StaticContact) -> None:
    """Pressure at rest on both faces [MPa]."""
    value = rest.normal_force / contacts.area / 1e6
    limits = (0.0, 1.05 * float(value.max()))
    shape = np.ptp(unrolled(contacts, RIGHT).reshape(-1, 2), axis=0)
    width = float(np.clip(1.0 * shape[0] / shape[1] + 2.8, 4.6, 9.0))  # faces about an inch high
    with figure(path, width, 3.1) as drawing:
        axes = drawing.subplots(2, 1, sharex=True)
        for ax, side in zip(axes, SIDES, strict=True):
            patches = _patches(ax, contacts, side)
            patches.set(array=value[contacts.face == side], cmap=SEQUENTIAL, clim=limits)
        axes[0].set_title(f"At rest, “{rest.model}”, pull {rest.applied:.4g} N")
        axes[1].set_xlabel("along the damper z [mm]")
        drawing.colorbar(patches, ax=axes, label="pressure [MPa]", shrink=0.9)


def contact_states(
    path: Path, rig: Rig, contacts: ContactElements, mode: str, states: Mapping[float, Integers]
) -> None:
    """State of every patch over a period at the peak, a column a force level, beside the damper.

    states: force [N] -> (n_contacts,) ContactState
    """
    across = min(len(states), ACROSS)
    rows = -(-len(states) // ACROSS)
    shape = np.ptp(unrolled(contacts, RIGHT).reshape(-1, 2), axis=0)
    high = max(COLUMN * float(shape[1] / shape[0]) + 0.3, 0.6)
    with figure(path, 2.4 + (COLUMN + 0.15) * across, 1.0 + 2 * high * rows) as drawing:
        grid = drawing.add_gridspec(2 * rows, across + 1, width_ratios=[2.0 / COLUMN, *[1.0] * across])
        draw_faces(drawing.add_subplot(grid[:2, 0]), rig)
        for i, (force, state) in enumerate(sorted(states.items())):
            for j, side in enumerate(SIDES):
                row, column = 2 * (i // ACROSS) + j, i % ACROSS
                ax = drawing.add_subplot(grid[row, column + 1])
                _states(ax, contacts, side, state)
                share = f"{_share(contacts, side, state == 0):.0f} % stuck"
                ax.set_title(f"{force:g} N: {share}" if j == 0 else share, fontsize=8.5)
                ax.set_ylabel(f"{SIDES[side]}\nup [mm]" if column == 0 else "", fontsize=8)
                ax.set_xlabel("along the damper z [mm]" if j == 1 else "", fontsize=8)
                ax.tick_params(labelsize=7.5, labelbottom=j == 1, labelleft=column == 0)
        drawing.suptitle(f"{mode}: contact states over a period at the peak", fontweight="bold", x=0.01, ha="left")
        handles = [Patch(facecolor=colour, edgecolor=INK, linewidth=0.4, label=name) for name, colour in STATES.items()]
        drawing.legend(handles=handles, loc="outside lower center", ncols=len(STATES))


def _states(ax: Axes, contacts: ContactElements, side: int, state: Integers) -> None:
    colours = ListedColormap(list(STATES.values()))
    norm = BoundaryNorm(np.arange(len(STATES) + 1) - 0.5, len(STATES))
    _patches(ax, contacts, side).set(array=state[contacts.face == side], cmap=colours, norm=norm)


def _patches(ax: Axes, contacts: ContactElements, side: int) -> PolyCollection:
    corners = unrolled(contacts, side)
    patches = PolyCollection(list(corners), edgecolors="white", linewidths=0.6)
    ax.add_collection(patches)
    ax.set(
        aspect="equal",
        xlim=(corners[..., 0].min(), corners[..., 0].max()),
        ylim=(0.0, corners[..., 1].max()),
        ylabel=f"{SIDES[side]}\nup the slope [mm]",
    )
    ax.grid(visible=False)
    return patches


def _share(contacts: ContactElements, side: int, chosen: NDArray[np.bool_]) -> float:
    """[%] of the face's area"""
    on = contacts.face == side
    return float(100 * contacts.area[on & chosen].sum() / contacts.area[on].sum())
