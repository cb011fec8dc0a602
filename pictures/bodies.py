"""Pictures of the rig itself: the mesh with its contact patches."""

from pathlib import Path
from typing import Any

import numpy as np

from updamp.geometry.contact_elements import LEFT, RIGHT
from updamp.geometry.rig_mesh import RigMesh, mirrored_mesh
from updamp.pictures.scene import Plotter, load_pyvista, patches, save, surface
from updamp.pictures.style import DARK_STEEL, INK, LEFT_FACE, RIGHT_FACE, STEEL

LIFT = -5e-5  # m, of the patches off the damper
FINE = 20_000  # elements from which edges are drawn thinner


def mesh(path: Path, rig_mesh: RigMesh) -> None:
    """The whole rig, the damper under its platforms, and the damper alone with the contact patches by face."""
    pv = load_pyvista()
    plotter = pv.Plotter(shape="1|2", splitting_position=0.4, window_size=(1500, 960), off_screen=True, border=False)
    edges = _edges(rig_mesh)
    elements = rig_mesh.blade_elements + rig_mesh.damper_elements
    plotter.subplot(0)
    _title(plotter, f"{elements:,} hexahedra of 20 nodes")
    _add_blades(plotter, rig_mesh, edges)
    _add_damper(plotter, rig_mesh, edges)
    _look(plotter, direction=(0.45, 0.25, 1.0), zoom=1.3)
    plotter.add_axes(color=INK, line_width=2)
    plotter.subplot(1)
    _title(plotter, "the damper under its platforms")
    _add_damper(plotter, rig_mesh, edges)
    _look(plotter, direction=(0.02, -0.03, 1.0), zoom=0.95)
    _add_blades(plotter, rig_mesh, edges)
    plotter.subplot(2)
    n, quality = len(rig_mesh.contacts), rig_mesh.min_scaled_jacobian
    _title(plotter, f"{n} contact patches: left face blue, right face orange; smallest scaled Jacobian {quality:.2f}")
    _add_damper(plotter, rig_mesh, edges)
    _look(plotter, direction=(0.5, 1.0, 0.55), zoom=1.0)
    plotter.enable_anti_aliasing("ssaa")
    save(plotter, path)


def _title(plotter: Plotter, text: str) -> None:
    plotter.set_background("white")
    title = plotter.add_text(text, position=(0.02, 0.94), viewport=True, font_size=9, color=INK)
    title.prop.background_color, title.prop.background_opacity = "white", 1.0  # what is drawn may reach behind it


def _add_blades(plotter: Plotter, rig_mesh: RigMesh, edges: dict[str, Any]) -> None:
    for body in (surface(rig_mesh.blade), surface(mirrored_mesh(rig_mesh.blade))):
        plotter.add_mesh(body, color=STEEL, ambient=0.35, **edges)


def _edges(rig_mesh: RigMesh) -> dict[str, Any]:
    fine = rig_mesh.blade_elements > FINE
    return {"show_edges": True, "edge_color": DARK_STEEL, "line_width": 0.5 if fine else 1.0, "edge_opacity": 0.6}


def _add_damper(plotter: Plotter, rig_mesh: RigMesh, edges: dict[str, Any]) -> None:
    plotter.add_mesh(surface(rig_mesh.damper), color=DARK_STEEL, ambient=0.3, **{**edges, "edge_color": INK})
    for side, colour in ((LEFT, LEFT_FACE), (RIGHT, RIGHT_FACE)):
        patch = patches(rig_mesh.contacts, side, LIFT)
        plotter.add_mesh(patch, color=colour, show_edges=True, edge_color="white", line_width=1.5, lighting=False)


def _look(plotter: Plotter, direction: tuple[float, float, float], zoom: float) -> None:
    """From `direction`, y up."""
    centre = np.array(plotter.renderer.center)
    plotter.camera_position = [tuple(centre + 1e3 * np.array(direction)), tuple(centre), (0.0, 1.0, 0.0)]
    plotter.reset_camera()
    plotter.camera.zoom(zoom)
