import numpy as np
import pytest
import pyvista
from vtkmodules.vtkCommonDataModel import VTK_QUADRATIC_HEXAHEDRON, VTK_TRIANGLE

from updamp.geometry.write_vtu import with_mid_edge_nodes, write_vtu


@pytest.fixture(scope="module")
def written(small, tmp_path_factory):
    files = write_vtu(small, tmp_path_factory.mktemp("mesh") / "made" / "on the way")
    return {file.stem: pyvista.read(file) for file in files}


def test_hexahedra_read_back(small, written):
    assert set(written) == {"blade_right", "blade_left", "damper", "contacts"}
    for name, component in (("blade_right", small.blade), ("blade_left", small.blade), ("damper", small.damper)):
        grid = written[name]
        assert set(grid.celltypes) == {VTK_QUADRATIC_HEXAHEDRON}
        assert grid.n_cells == len(component.hexahedra)
        volume = grid.compute_cell_sizes(length=False, area=False)["Volume"]
        assert volume.min() > 0
        corners = component.vertices[component.hexahedra]
        # an extruded cell: the quadrilateral's area times its length along z
        diagonals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        np.testing.assert_allclose(volume, diagonals[:, 2] / 2 * (corners[:, 4] - corners[:, 0])[:, 2], rtol=1e-9)


def test_mid_edge_nodes_are_where_vtk_expects_them(written):
    for grid in (written["damper"], written["blade_left"]):
        for edge in grid.get_cell(5).edges:
            first, second, middle = edge.points
            np.testing.assert_allclose(middle, (first + second) / 2, atol=1e-15)


def test_mid_edge_nodes_are_shared(small):
    nodes, hexahedra = with_mid_edge_nodes(small.damper)
    assert len(np.unique(np.round(nodes, 12), axis=0)) == len(nodes) == len(np.unique(hexahedra))


def test_blades_are_mirror_images(written):
    right, left = (np.asarray(written[name].points) for name in ("blade_right", "blade_left"))
    assert right[:, 0].min() > 0 > left[:, 0].max()
    np.testing.assert_allclose(left * [-1, 1, 1], right, atol=1e-15)


def test_contacts_read_back(small, written):
    grid = written["contacts"]
    assert set(grid.celltypes) == {VTK_TRIANGLE}
    np.testing.assert_allclose(grid.cell_data["area"], small.contacts.area, rtol=1e-14)
    np.testing.assert_array_equal(grid.cell_data["face"], small.contacts.face)
    np.testing.assert_allclose(grid.compute_cell_sizes()["Area"], small.contacts.area, rtol=1e-6)
