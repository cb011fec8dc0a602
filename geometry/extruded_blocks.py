"""Structured hexahedra by gmsh's built-in kernel: quadrilateral blocks of a section, extruded along z."""

from __future__ import annotations

import ctypes
import signal
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

import gmsh
import numpy as np
from numpy.typing import NDArray

from updamp.geometry.rig_mesh import ComponentMesh


@contextmanager
def signal_handlers_kept() -> Iterator[None]:
    """What happens on a signal is, afterwards, what it was before.

    gmsh's start resets SIGPIPE, which Python ignores so as to raise BrokenPipeError: a write to a worker process that
    is gone would then end this process without a word. It resets SIGTERM too, which would end it without storing what
    is solved, and leave its workers behind. By the C functions, since `signal.signal` works in the main thread only.
    """
    get, put = ctypes.pythonapi.PyOS_getsig, ctypes.pythonapi.PyOS_setsig
    get.restype = put.restype = ctypes.c_void_p
    put.argtypes = [ctypes.c_int, ctypes.c_void_p]
    before = {number: get(number) for number in signal.valid_signals()}
    try:
        yield
    finally:
        for number, handler in before.items():
            if get(number) != handler:
                put(number, handler)


HEXAHEDRON, QUADRILATERAL = 5, 3  # gmsh's element types, first order

Edge = tuple[str, str]


@dataclass(frozen=True)
class Block:
    """Quadrilateral of a section; corners counterclockwise.

    across: divisions of the edges 0-1 and 2-3; up: of the edges 1-2 and 3-0
    """

    corners: tuple[str, str, str, str]
    across: int
    up: int

    @property
    def edges(self) -> tuple[Edge, Edge, Edge, Edge]:
        a, b, c, d = self.corners
        return (a, b), (b, c), (c, d), (d, a)


@dataclass(frozen=True)
class CrossSection:
    """Blocks to be extruded.

    points: (x, y) of every corner [m]
    sides: named groups of the section's edges; each becomes a group of faces
    ends: names of the groups of faces at z = -width/2 and z = +width/2, or none
    marks: section points whose vertex at z = 0 is to be named
    """

    name: str
    points: Mapping[str, tuple[float, float]]
    blocks: tuple[Block, ...]
    sides: Mapping[str, tuple[Edge, ...]]
    marks: Mapping[str, str]
    ends: tuple[str, str] | None = None


def extrude_section(section: CrossSection, width: float, layers: int) -> ComponentMesh:
    """Mesh the section's blocks and extrude them from z = -width/2 to +width/2 [m] in an even number of layers.

    raises: RuntimeError when gmsh does not give one hexahedron a cell (an inconsistent section)
    """
    with gmsh_model(section.name):
        _add_physical_groups(section, width, layers)
        gmsh.model.mesh.generate(3)
        mesh = _read_out(section)
    expected = layers * sum(block.across * block.up for block in section.blocks)
    if len(mesh.hexahedra) != expected:
        raise RuntimeError(f"gmsh gave {len(mesh.hexahedra)} hexahedra for {section.name}; {expected} were asked for")
    return mesh


@contextmanager
def gmsh_model(name: str) -> Iterator[None]:
    """A silent gmsh with an empty model; a session that is already open is used and left open."""
    opened = not gmsh.isInitialized()
    if opened:
        # Without user files the result depends on this code only; uninterruptible, gmsh leaves Python's handler of
        # interruptions alone (and so works outside the main thread).
        with signal_handlers_kept():
            gmsh.initialize(argv=["gmsh", "-nopopup"], readConfigFiles=False, run=False, interruptible=False)
    terminal = gmsh.option.getNumber("General.Terminal")
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add(name)
    try:
        yield
    finally:
        gmsh.model.remove()
        if opened:
            gmsh.finalize()
        else:
            gmsh.option.setNumber("General.Terminal", terminal)


def _add_physical_groups(section: CrossSection, width: float, layers: int) -> None:
    """Geometry, transfinite divisions and physical groups of the section in the current model."""
    geo = gmsh.model.geo
    points = {key: geo.addPoint(x, y, -width / 2) for key, (x, y) in section.points.items()}
    lines: dict[frozenset[str], int] = {}
    surfaces = []
    for block in section.blocks:
        loop = []
        for edge, divisions in zip(block.edges, 2 * (block.across, block.up), strict=True):
            line = lines.get(frozenset(edge))
            if line is None:
                line = lines[frozenset(edge)] = geo.addLine(points[edge[0]], points[edge[1]])
                geo.mesh.setTransfiniteCurve(line, divisions + 1)
                loop.append(line)
            else:
                loop.append(-line)  # the neighbour, counterclockwise too, ran along it the other way
        surface = geo.addPlaneSurface([geo.addCurveLoop(loop)])
        geo.mesh.setTransfiniteSurface(surface, cornerTags=[points[corner] for corner in block.corners])
        geo.mesh.setRecombine(2, surface)
        surfaces.append(surface)
    extruded = geo.extrude([(2, s) for s in surfaces], 0, 0, width, numElements=[layers], recombine=True)
    geo.synchronize()
    volumes = [tag for dim, tag in extruded if dim == 3]
    gmsh.model.addPhysicalGroup(3, volumes, name=section.name)
    for name, edges in section.sides.items():
        # asked of the model, because extrusion merges the sides that neighbouring blocks share
        tags = [_swept_surface(lines[frozenset(edge)], surfaces) for edge in edges]
        gmsh.model.addPhysicalGroup(2, tags, name=name)
    if section.ends is not None:
        back, front = section.ends
        tops = [extruded[i - 1][1] for i, (dim, _) in enumerate(extruded) if dim == 3]  # each precedes its volume
        gmsh.model.addPhysicalGroup(2, surfaces, name=back)
        gmsh.model.addPhysicalGroup(2, tops, name=front)


def _swept_surface(line: int, section_surfaces: list[int]) -> int:
    upward, _ = gmsh.model.getAdjacencies(1, line)
    (surface,) = set(upward.tolist()) - set(section_surfaces)
    return int(surface)


def _read_out(section: CrossSection) -> ComponentMesh:
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    number = np.full(int(tags.max()) + 1, -1, dtype=np.int64)
    number[tags] = np.arange(len(tags))
    vertices = coordinates.reshape(-1, 3)
    groups = {
        gmsh.model.getPhysicalName(dim, tag): gmsh.model.getEntitiesForPhysicalGroup(dim, tag)
        for dim, tag in gmsh.model.getPhysicalGroups()
    }
    hexahedra = number[_connectivity(HEXAHEDRON, 8, groups.pop(section.name))]
    faces = {name: number[_connectivity(QUADRILATERAL, 4, entities)] for name, entities in groups.items()}
    points = {name: vertex_at(vertices, (*section.points[corner], 0.0)) for name, corner in section.marks.items()}
    return ComponentMesh(section.name, vertices, hexahedra, faces, points)


def _connectivity(element_type: int, n_nodes: int, entities: NDArray[np.int32]) -> NDArray[np.uint64]:
    nodes = [gmsh.model.mesh.getElementsByType(element_type, int(tag))[1] for tag in entities]
    return np.concatenate(nodes).reshape(-1, n_nodes)


def vertex_at(vertices: NDArray[np.float64], place: tuple[float, float, float]) -> int:
    """Number of the vertex at `place` [m].

    raises: ValueError when none lies within a nanometre of it
    """
    distance = np.linalg.norm(vertices - np.asarray(place), axis=1)
    nearest = int(distance.argmin())
    if distance[nearest] > 1e-9:
        raise ValueError(f"no vertex at {place} m; the nearest is {distance[nearest]:.3g} m away")
    return nearest
