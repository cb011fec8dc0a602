"""The interface of a component: the degrees of freedom at its contact elements and named points."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from updamp.fem.assembly import SystemMatrices
from updamp.fem.coupling import Coupling, face_average
from updamp.fem.quadratic_mesh import QuadraticMesh
from updamp.geometry.contact_elements import LEFT, RIGHT, ContactElements

Floats = NDArray[np.float64]

BLADE_POINTS = ("excitation.x", "tip.x", "platform.x", "platform.y")
DAMPER_POINTS = tuple(f"corner_{side}.{axis}" for side in ("left", "right") for axis in "xy") + tuple(
    f"wire_{end}.{axis}" for end in ("back", "front") for axis in "xyz"
)


@dataclass(frozen=True, eq=False)
class Interface:
    """operator^T u reads the interface displacements off a field u; operator f spreads interface forces f.

    Columns as in ReducedComponent: 3 a contact element in its local axes (t1, t2, n), then the points.

    operator: (n_dofs, n_interface) on the free nodes [-]
    """

    operator: sparse.csc_array
    points: tuple[str, ...]


def blade_interface(
    mesh: QuadraticMesh, matrices: SystemMatrices, contacts: ContactElements, coupling: Coupling
) -> Interface:
    """Of the right-hand blade: contact elements of its face, then BLADE_POINTS."""
    weights = coupling(mesh.nodes, mesh.faces["contact"], on_face(contacts, RIGHT))
    columns = [
        local_columns(weights, on_face(contacts, RIGHT)),
        *(_node_column(mesh, *point.split(".")) for point in BLADE_POINTS),
    ]
    return _interface(columns, matrices, BLADE_POINTS)


def damper_interface(
    mesh: QuadraticMesh, matrices: SystemMatrices, contacts: ContactElements, coupling: Coupling
) -> Interface:
    """Contact elements of the left face, then of the right, then DAMPER_POINTS; a wire holds a whole end face."""
    columns = []
    for side, group in ((LEFT, "contact_left"), (RIGHT, "contact_right")):
        weights = coupling(mesh.nodes, mesh.faces[group], on_face(contacts, side))
        columns.append(local_columns(weights, on_face(contacts, side)))
    for point in DAMPER_POINTS:
        name, axis = point.split(".")
        if name.startswith("wire"):
            average = face_average(mesh.nodes, mesh.faces[name.replace("wire", "end")])
            columns.append(_along_axis(sparse.csr_array(average[None, :]), axis))
        else:
            columns.append(_node_column(mesh, name, axis))
    return _interface(columns, matrices, DAMPER_POINTS)


def on_face(contacts: ContactElements, side: int) -> ContactElements:
    """The contact elements of one face."""
    keep = contacts.face == side
    return ContactElements(
        *(getattr(contacts, name)[keep] for name in ("face", "point", "area")),
        *(getattr(contacts, name)[keep] for name in ("tangent1", "tangent2", "normal", "triangle")),
    )


def local_columns(weights: sparse.csr_array, contacts: ContactElements) -> sparse.csc_array:
    """(3 n_nodes, 3 n_contacts): column 3 i + d has weights[i, j] axes[i, d] at node j."""
    entries = weights.tocoo()
    contact, node = entries.coords
    values = entries.data[:, None, None] * contacts.axes[contact]
    direction, component = np.arange(3)[:, None], np.arange(3)
    rows = np.broadcast_to(3 * node[:, None, None] + component, values.shape)
    columns = np.broadcast_to(3 * contact[:, None, None] + direction, values.shape)
    shape = (3 * weights.shape[1], 3 * weights.shape[0])
    return sparse.csc_array((values.ravel(), (rows.ravel(), columns.ravel())), shape=shape)


def _node_column(mesh: QuadraticMesh, point: str, axis: str) -> sparse.csc_array:
    weights = sparse.csr_array(([1.0], ([0], [mesh.points[point]])), shape=(1, len(mesh.nodes)))
    return _along_axis(weights, axis)


def _along_axis(weights: sparse.csr_array, axis: str) -> sparse.csc_array:
    direction = np.eye(3)[["xyz".index(axis)]]
    return sparse.csc_array(sparse.kron(weights, direction).T)


def _interface(columns: list[sparse.csc_array], matrices: SystemMatrices, points: tuple[str, ...]) -> Interface:
    operator = sparse.hstack(columns, format="csr")
    return Interface(sparse.csc_array(operator[matrices.free_dofs]), points)
