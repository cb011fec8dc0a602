"""Mode shapes: a panel of the first ones, and one in motion."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from updamp.geometry.rig_mesh import ComponentMesh
from updamp.pictures.scene import Plotter, load_pyvista, photograph, save, surface
from updamp.pictures.style import COLOURS, INK, LIGHT_GREY, SEQUENTIAL

if TYPE_CHECKING:
    import pyvista as pv

Floats = NDArray[np.float64]

LARGEST = 0.06  # drawn displacement over the height of the rig
BELOW_TITLE = 0.97  # zoom that leaves the tips below the title
FRAMES, FRAME_SECONDS = 24, 0.06
LENGTHWISE = (0.35, 0.2, 1.0)  # the eye looks along the damper, so that bending in x is seen


@dataclass(frozen=True, eq=False)
class ModeShape:
    """A deformed rig.

    parts: the bodies, each with the displacement of its vertices (n_vertices, 3), to any scale common to all
    """

    title: str
    parts: tuple[tuple[ComponentMesh, Floats], ...]


def panel(path: Path, shapes: Sequence[ModeShape]) -> None:
    """The shapes side by side, coloured by size of displacement, on the outline at rest."""
    pv = load_pyvista()
    columns = min(len(shapes), 3)
    rows = -(-len(shapes) // columns)
    plotter = pv.Plotter(shape=(rows, columns), window_size=(430 * columns, 520 * rows), off_screen=True, border=False)
    plotter.set_background("white")
    for place, shape in enumerate(shapes):
        plotter.subplot(*divmod(place, columns))
        _add(plotter, shape, phase=1.0)
        plotter.add_text(shape.title, position=(0.04, 0.93), viewport=True, font_size=9, color=INK)
    plotter.enable_anti_aliasing("ssaa")
    save(plotter, path)


def animation(path: Path, shape: ModeShape) -> None:
    """One period of a shape as an animated GIF."""
    pv = load_pyvista()
    plotter = pv.Plotter(window_size=(420, 520), off_screen=True)
    plotter.set_background("white")
    plotter.add_text(shape.title, position=(0.04, 0.93), viewport=True, font_size=9, color=INK)
    bodies = _add(plotter, shape, phase=0.0)
    plotter.enable_anti_aliasing("ssaa")
    frames = []
    for phase in np.sin(2 * np.pi * np.arange(FRAMES) / FRAMES):
        for body, rest, displacement in bodies:
            body.points = rest + phase * displacement
        frames.append(photograph(plotter))
    plotter.close()
    palette = frames[FRAMES // 4].quantize(COLOURS // 2, dither=Image.Dither.NONE)
    frames = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    path.parent.mkdir(parents=True, exist_ok=True)
    frames[0].save(
        path, save_all=True, append_images=frames[1:], duration=int(1e3 * FRAME_SECONDS), loop=0, optimize=True
    )


def _add(plotter: Plotter, shape: ModeShape, phase: float) -> "list[tuple[pv.PolyData, Floats, Floats]]":
    """Draw the rest and the deformed bodies; returns these, with their points at rest and displacement [mm]."""
    height = 1e3 * max(float(np.ptp(body.vertices[:, 1])) for body, _ in shape.parts)
    sizes = [np.linalg.norm(displacement, axis=1) for _, displacement in shape.parts]
    largest = max(float(size.max()) for size in sizes)
    scale = LARGEST * height / largest if largest > 0 else 0.0
    drawn = []
    for (body, displacement), size in zip(shape.parts, sizes, strict=True):
        skin = surface(body)
        nodes = skin.point_data["node"]
        plotter.add_mesh(skin.copy().extract_feature_edges(30.0), color=LIGHT_GREY, line_width=1.5)
        rest, moved = np.array(skin.points), scale * displacement[nodes]
        skin.points = rest + phase * moved
        skin.point_data["displacement"] = size[nodes]
        plotter.add_mesh(
            skin, scalars="displacement", cmap=SEQUENTIAL, clim=(0.0, largest), ambient=0.35, show_scalar_bar=False
        )
        drawn.append((skin, rest, moved))
    centre = np.array(plotter.renderer.center)
    plotter.camera_position = [tuple(centre + 1e3 * np.array(LENGTHWISE)), tuple(centre), (0.0, 1.0, 0.0)]
    plotter.reset_camera()
    plotter.camera.zoom(BELOW_TITLE)
    return drawn
