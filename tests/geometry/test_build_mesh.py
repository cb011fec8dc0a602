import ctypes
import os
import signal
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from math import cos, radians, sin, tan
from pathlib import Path

import gmsh
import numpy as np
import pytest
import pyvista
from scipy.spatial import cKDTree

from updamp.geometry.build_mesh import build_mesh
from updamp.geometry.extruded_blocks import signal_handlers_kept
from updamp.geometry.rig_mesh import GeometryError, mirrored_mesh, scaled_jacobian
from updamp.model.rig_files import load_rig

# A hexahedron as six tetrahedra about its diagonal 0-6; exact for the planar-faced cells of an extrusion.
TETRAHEDRA = np.array([[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]])

REFERENCE = Path(__file__).parents[2] / "rigs" / "pesaresi2017.toml"


def volumes(component):
    corners = component.vertices[component.hexahedra][:, TETRAHEDRA]
    return np.linalg.det(corners[:, :, 1:] - corners[:, :, :1]).sum(axis=1) / 6


def polygon_area(points):
    x, y = np.array(points).T
    return abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def blade_outline(rig):
    inner = rig.blade.axis_offset - rig.blade.thickness / 2
    outer, edge = inner + rig.blade.thickness, rig.platform.gap / 2
    low = rig.platform.top - rig.platform.edge_thickness
    junction = low - (inner - edge) * tan(rig.platform.underside_angle)
    top, height = rig.platform.top, rig.blade.height
    return [(inner, 0), (outer, 0), (outer, height), (inner, height), (inner, top), (edge, top), (edge, low),
            (inner, junction)]  # fmt: skip


def damper_outline(rig):
    a, d = rig.platform.underside_angle, rig.damper
    low = rig.platform.top - rig.platform.edge_thickness
    (x1, y1), (x2, y2) = (
        (rig.platform.gap / 2 + s * cos(a), low - s * sin(a)) for s in (d.face_start, d.face_start + d.face_length)
    )
    right = [(x2, y2 - d.base_height), (x2, y2), (x1, y1), (d.apex_flat / 2, y1 + d.apex_height)]
    if d.apex_height == 0:
        right.pop()
    return right + [(-x, y) for x, y in reversed(right)]


def assert_volumes(rig, mesh):
    for component, outline in ((mesh.blade, blade_outline(rig)), (mesh.damper, damper_outline(rig))):
        cells = volumes(component)
        assert cells.min() > 0
        np.testing.assert_allclose(cells.sum(), polygon_area(outline) * rig.blade.width, rtol=1e-12)


def assert_contacts_match(mesh):
    """Vertex by vertex, on both sides."""
    for blade, side in ((mesh.blade, "contact_right"), (mirrored_mesh(mesh.blade), "contact_left")):
        of_blade = blade.vertices[np.unique(blade.faces["contact"])]
        of_damper = mesh.damper.vertices[np.unique(mesh.damper.faces[side])]
        distance, partner = cKDTree(of_damper).query(of_blade)
        assert distance.max() < 1e-12
        assert len(of_damper) == len(of_blade) == len(np.unique(partner))


def assert_sound(rig, mesh):
    assert_volumes(rig, mesh)
    assert_contacts_match(mesh)
    assert mesh.min_scaled_jacobian > 0.2


def test_full_has_the_published_size():
    full = build_mesh(load_rig(REFERENCE), "full")
    assert full.blade_elements == pytest.approx(54_972, rel=0.03)
    assert full.damper_elements == pytest.approx(3_620, rel=0.03)
    assert len(full.contacts) == 146


def test_small_and_medium_sizes(rig, small):
    assert small.blade_elements + small.damper_elements == pytest.approx(2_000, rel=0.1)
    assert len(small.contacts) == 36
    medium = build_mesh(rig, "medium")
    assert 8_000 < medium.blade_elements + medium.damper_elements < 14_000
    assert len(medium.contacts) == 146


@pytest.mark.parametrize("preset", ["small", "full"])
def test_volume_orientation_and_matching_faces(rig, request, preset):
    assert_sound(rig, request.getfixturevalue(preset))


def test_soundness_check_can_fail(rig, small):
    moved = rig.damper.model_copy(update={"face_start": rig.damper.face_start + 1e-6})
    other = build_mesh(rig.model_copy(update={"damper": moved}), "small")
    mixed = replace(small, damper=other.damper)
    with pytest.raises(AssertionError):
        assert_contacts_match(mixed)
    with pytest.raises(AssertionError):
        assert_volumes(rig, mixed)


def test_groups_lie_where_they_should(rig, full):
    blade, damper = full.blade, full.damper
    width, face = rig.blade.width, rig.damper.face_length
    assert set(blade.faces) == {"root", "contact"}
    assert set(damper.faces) == {"contact_left", "contact_right", "end_back", "end_front"}
    np.testing.assert_allclose(face_area(blade, "root"), rig.blade.thickness * width, rtol=1e-12)
    assert np.abs(blade.vertices[blade.faces["root"]][..., 1]).max() < 1e-15
    for component, name in ((blade, "contact"), (damper, "contact_left"), (damper, "contact_right")):
        np.testing.assert_allclose(face_area(component, name), face * width, rtol=1e-12)
    for name, z in (("end_back", -width / 2), ("end_front", width / 2)):
        np.testing.assert_allclose(damper.vertices[damper.faces[name]][..., 2], z, atol=1e-15)
        np.testing.assert_allclose(face_area(damper, name), polygon_area(damper_outline(rig)), rtol=1e-12)


def face_area(component, name):
    corners = component.vertices[component.faces[name]]
    diagonals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    return np.linalg.norm(diagonals, axis=1).sum() / 2


def test_faces_belong_to_hexahedra(small):
    sides = np.array([[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])
    for component in (small.blade, small.damper, mirrored_mesh(small.blade)):
        every, count = np.unique(np.sort(component.hexahedra[:, sides].reshape(-1, 4)), axis=0, return_counts=True)
        outer = {tuple(quad) for quad in every[count == 1]}
        for quads in component.faces.values():
            assert {tuple(quad) for quad in np.sort(quads)} <= outer


def test_named_points(rig, small):
    outer = rig.blade.axis_offset + rig.blade.thickness / 2
    end = rig.damper.face_start + rig.damper.face_length
    half = rig.platform.gap / 2 + end * cos(rig.platform.underside_angle)
    bottom = min(y for _, y in damper_outline(rig))
    places = {name: small.blade.vertices[number] for name, number in small.blade.points.items()}
    places |= {name: small.damper.vertices[number] for name, number in small.damper.points.items()}
    expected = {
        "excitation": (outer, rig.excitation.height, 0),
        "tip": (outer, rig.blade.height - rig.response.below_top, 0),
        "platform": (rig.platform.gap / 2, rig.platform.top, 0),
        "corner_left": (-half, bottom, 0),
        "corner_right": (half, bottom, 0),
    }
    assert places.keys() == expected.keys()
    for name, place in expected.items():
        np.testing.assert_allclose(places[name], place, atol=1e-12)


def test_mirror_image(small):
    left = mirrored_mesh(small.blade)
    np.testing.assert_array_equal(left.vertices[:, 0], -small.blade.vertices[:, 0])
    np.testing.assert_array_equal(left.vertices[:, 1:], small.blade.vertices[:, 1:])
    np.testing.assert_allclose(volumes(left), volumes(small.blade), rtol=1e-12)
    np.testing.assert_array_equal(mirrored_mesh(left).hexahedra, small.blade.hexahedra)
    np.testing.assert_array_equal(np.sort(left.hexahedra), np.sort(small.blade.hexahedra))


def test_scaled_jacobian_of_known_cells():
    cube = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
    cell = np.arange(8)[None]
    sheared = cube + np.outer(cube[:, 1], [1.0, 0, 0])  # 45 deg
    for vertices, expected in ((cube, 1.0), (cube * [5, 1, 0.1], 1.0), (sheared, np.sqrt(0.5))):
        np.testing.assert_allclose(scaled_jacobian(vertices, cell), expected, rtol=1e-14)
    np.testing.assert_allclose(scaled_jacobian(cube * [-1, 1, 1], cell), -1.0, rtol=1e-14)


def test_scaled_jacobian_agrees_with_vtk(small):
    for component in (small.blade, small.damper):
        grid = pyvista.UnstructuredGrid({pyvista.CellType.HEXAHEDRON: component.hexahedra}, component.vertices)
        of_vtk = grid.cell_quality("scaled_jacobian")["scaled_jacobian"]
        np.testing.assert_allclose(scaled_jacobian(component.vertices, component.hexahedra), of_vtk, rtol=1e-6)


def test_reported_quality_is_that_of_the_flattest_corner(rig, small):
    slope = np.arctan2(rig.damper.apex_height, rig.face_top[0] - rig.damper.apex_flat / 2)
    assert small.min_scaled_jacobian == pytest.approx(min(sin(slope), cos(rig.platform.underside_angle)), rel=1e-12)


def test_without_apex_inner_piece_or_base(rig_file):
    rig = load_rig(rig_file, {"damper.apex_height": "0 mm"})
    damper = rig.damper.model_copy(update={"base_height": 0.0, "face_start": 0.0})
    for variant in (rig, rig.model_copy(update={"damper": damper})):
        assert_sound(variant, build_mesh(variant, "small"))


def test_bad_meshes_are_refused_by_name(rig, rig_file):
    with pytest.raises(GeometryError, match=r"mesh = coarse: .*small, medium, full"):
        build_mesh(rig, "coarse")
    flat_apex = load_rig(rig_file, {"damper.apex_flat": "0.3 mm"})
    with pytest.raises(GeometryError, match=r"damper.apex_flat = 0\.3 mm: .* 0\.17\d; it must exceed 0\.2"):
        build_mesh(flat_apex, "small")
    steep = {"platform.underside_angle": "79 deg", "platform.top": "110 mm", "damper.apex_height": "0 mm"}
    with pytest.raises(GeometryError, match=r"platform.underside_angle = 79 deg: .* 0\.191"):
        build_mesh(load_rig(rig_file, steep), "small")


def test_gmsh_leaves_no_trace(rig, small, capfd):
    handler = signal.getsignal(signal.SIGINT)
    with ThreadPoolExecutor(1) as pool:
        again = pool.submit(build_mesh, rig, "small").result()
    np.testing.assert_array_equal(again.blade.vertices, small.blade.vertices)
    np.testing.assert_array_equal(again.blade.hexahedra, small.blade.hexahedra)
    assert not gmsh.isInitialized()
    assert signal.getsignal(signal.SIGINT) is handler
    assert capfd.readouterr() == ("", "")


def test_gmsh_leaves_all_signals_as_they_were(rig):
    """It resets SIGTERM: a run would end without storing what is solved, and leave its workers."""
    handler_of = ctypes.pythonapi.PyOS_getsig  # that of the process; Python's own record does not change
    handler_of.restype = ctypes.c_void_p
    before = signal.signal(signal.SIGTERM, lambda *_: None)
    try:
        handlers = {number: handler_of(number) for number in signal.valid_signals()}
        build_mesh(rig, "small")
        assert {number: handler_of(number) for number in signal.valid_signals()} == handlers
    finally:
        signal.signal(signal.SIGTERM, before)


@pytest.mark.parametrize("in_a_thread", [False, True])
def test_a_write_to_a_worker_that_is_gone_does_not_end_this_process(rig, in_a_thread):
    """gmsh resets SIGPIPE; `diagnose` would end without a word where one of its workers is killed."""
    with ThreadPoolExecutor(1) as pool:
        pool.submit(build_mesh, rig, "small").result() if in_a_thread else build_mesh(rig, "small")
    reader, writer = os.pipe()
    os.close(reader)
    with open(writer, "wb", buffering=0) as pipe, pytest.raises(BrokenPipeError):
        pipe.write(b".")


def test_an_open_gmsh_session_is_kept(rig, small):
    with signal_handlers_kept():
        gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("mine")
        within = build_mesh(rig, "small")
        np.testing.assert_allclose(within.damper.vertices, small.damper.vertices, atol=1e-15)
        assert "mine" in gmsh.model.list()
        assert "blade" not in gmsh.model.list()
    finally:
        gmsh.finalize()


@pytest.mark.parametrize("seed", range(12))
def test_other_dimensions_build(rig_file, seed):
    """Random rigs, admissible by construction."""
    random = np.random.default_rng(seed)
    angle = random.uniform(25, 65)
    a, thickness, gap, edge = radians(angle), random.uniform(4, 10), random.uniform(2, 6), random.uniform(5, 14)
    axis = random.uniform(15, 26)
    reach = axis - thickness / 2 - gap / 2
    start = random.uniform(0.5, 1.5)
    length = random.uniform(0.3, 0.8) * (reach / cos(a) - start)
    face_top = gap / 2 + start * cos(a)
    flat = random.uniform(1.0, 1.5) * face_top
    lengths = {
        "blade.thickness": thickness,
        "blade.axis_offset": axis,
        "blade.width": random.uniform(30, 80),
        "platform.gap": gap,
        "platform.edge_thickness": edge,
        "platform.top": edge + reach * tan(a) + random.uniform(22, 40),
        "damper.face_start": start,
        "damper.face_length": length,
        "damper.apex_flat": flat,
        "damper.apex_height": random.uniform(0.6, 0.95) * (face_top - flat / 2) * tan(a),
        "damper.base_height": random.uniform(0.5, 2),
    }
    overrides = {key: f"{value:.4f} mm" for key, value in lengths.items()}
    rig = load_rig(rig_file, overrides | {"platform.underside_angle": f"{angle:.4f} deg", "blade.height": "170 mm"})
    assert_sound(rig, build_mesh(rig, "small"))
