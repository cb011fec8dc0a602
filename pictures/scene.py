"""Off-screen scenes of the rig: the one place that loads pyvista."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from updamp.geometry.contact_elements import ContactElements
from updamp.geometry.rig_mesh import ComponentMesh
from updamp.parallel.system_libraries import lacking
from updamp.pictures.style import write_png

if TYPE_CHECKING:
    import pyvista as pv

Floats = NDArray[np.float64]
Plotter = Any  # a pyvista.Plotter, whose decorated methods type checkers misread

# Without them pyvista does not fail with a message, it crashes: shared library -> Debian package.
LIBRARIES: Mapping[str, str] = {"libGL.so.1": "libgl1", "libEGL.so.1": "libegl1"}


class RenderingError(RuntimeError):
    """Pictures of the mesh cannot be drawn on this machine; the message says how to get what is missing."""


def load_pyvista() -> Any:
    """The module, ready for drawing without a screen.

    raises: RenderingError naming the system libraries that are missing
    """
    if missing := lacking(LIBRARIES):
        raise RenderingError(f"no pictures of the mesh: {missing}")
    if "DISPLAY" not in os.environ:
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    import pyvista

    pyvista.OFF_SCREEN = True
    return pyvista


def surface(component: ComponentMesh) -> "pv.PolyData":
    """The component's skin [mm], with "node": numbers of its vertices."""
    pv = load_pyvista()
    n = len(component.hexahedra)
    cells = np.column_stack([np.full(n, 8), component.hexahedra]).ravel()
    grid = pv.UnstructuredGrid(cells, np.full(n, pv.CellType.HEXAHEDRON), 1e3 * component.vertices)
    grid.point_data["node"] = np.arange(len(component.vertices))
    return grid.extract_surface(algorithm="dataset_surface")


def patches(contacts: ContactElements, side: int, lift: float = 0.0) -> "pv.PolyData":
    """One face's contact patches [mm], lifted off it by so much [m] so that they are seen."""
    on = contacts.face == side
    corners = contacts.triangle[on] - lift * contacts.normal[on][:, None]
    triangles = np.column_stack([np.full(on.sum(), 3), np.arange(3 * on.sum()).reshape(-1, 3)])
    return load_pyvista().PolyData(1e3 * corners.reshape(-1, 3), triangles.ravel())


def photograph(plotter: Plotter) -> Image.Image:
    plotter.render()
    return Image.fromarray(np.asarray(plotter.screenshot(return_img=True)))


def save(plotter: Plotter, path: Path) -> None:
    picture = photograph(plotter)
    plotter.close()
    write_png(picture, path)
