"""How large a rig's problems are: unknowns, memory and time of each mesh preset, before anything is meshed."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from updamp.rig.mesh_divisions import MeshDivisions
from updamp.rig.rig import Rig

COMPONENTS_OF_3D = 3
VECTORS_A_MODE = 2.5  # that ARPACK is given (fem/modes.py: 60 for 24)


@dataclass(frozen=True)
class SizeOptions:
    """What memory and time are extrapolated from. Measured on the reference rig (README.md), 2 processors of 2026-11.

    base: of Python with its libraries [bytes]
    factor, unknowns: memory of the finite elements [bytes] at this number of unknowns; it grows with the fill of a
        nested dissection in three dimensions, n^(4/3) (A. George, SIAM J. Numer. Anal. 10, 1973). On the presets small
        and medium, 0.52 and 1.74 GB were measured; this says 0.44 and 1.40
    seconds, begin: likewise the time from mesh to reduced model [s], grows with n^(6/5); begin: of the smallest mesh
    matrices: dense ones of all unknowns of harmonic balance that one point of a curve takes (Jacobian, its factors,
        the receptance, what is built from)
    arrays: numbers kept for each time sample of a contact's three directions, tangents included
    """

    base: float = 0.35e9
    factor: float = 7.25e9
    unknowns: int = 375_711
    memory_power: float = 4 / 3
    begin: float = 8.0
    seconds: float = 246.0
    time_power: float = 6 / 5
    matrices: int = 4
    arrays: int = 30


USUAL = SizeOptions()


@dataclass(frozen=True)
class Size:
    """Of one mesh preset. unknowns: of one blade's finite elements, which take the most; damper: of the damper's
    balance: unknowns of harmonic balance, all contacts in three directions; samples: time samples of a period's cycles
    """

    unknowns: int
    damper: int
    balance: int
    samples: int
    contacts: int

    def elements_memory(self) -> float:
        """Of the finite elements [bytes]."""
        return USUAL.base + USUAL.factor * (self.unknowns / USUAL.unknowns) ** USUAL.memory_power

    def elements_seconds(self) -> float:
        """From mesh to reduced model [s]."""
        return USUAL.begin + USUAL.seconds * (self.unknowns / USUAL.unknowns) ** USUAL.time_power

    def most_unknowns(self, memory: float) -> int:
        """Of the finite elements that so much memory [bytes] holds."""
        share = max(memory - USUAL.base, 0.0) / USUAL.factor
        return int(USUAL.unknowns * share ** (1 / USUAL.memory_power))

    def matrices_memory(self) -> float:
        """Of the dense matrices of one curve's points [bytes]."""
        return 8.0 * USUAL.matrices * self.balance**2

    def samples_memory(self) -> float:
        """Of the contacts' time samples [bytes]."""
        return 8.0 * USUAL.arrays * COMPONENTS_OF_3D * self.contacts * self.samples

    def curve_memory(self) -> float:
        """Of the process that traces one curve [bytes]."""
        return USUAL.base + self.matrices_memory() + self.samples_memory()


def size_of(rig: Rig, preset: str) -> Size:
    """preset: one of the rig file's"""
    mesh, balance = rig.mesh[preset], rig.harmonic_balance
    coefficients = sum(1 if k == 0 else 2 for k in balance.harmonics)
    return Size(
        unknowns=COMPONENTS_OF_3D * _nodes(*_blade_section(mesh), mesh.width),
        damper=COMPONENTS_OF_3D * _nodes(*_damper_section(rig, mesh), mesh.width),
        balance=COMPONENTS_OF_3D * mesh.contact_elements * coefficients,
        samples=balance.time_samples * balance.cycles,
        contacts=mesh.contact_elements,
    )


def finer_presets(rig: Rig, preset: str) -> tuple[str, ...]:
    """What tells the numerical error of a preset: of those of the rig file that are nowhere coarser the smallest with a
    finer mesh and the smallest with more contact elements, which may be one; none where there are none."""

    def smallest(wanted: Callable[[MeshDivisions], bool]) -> Iterator[str]:
        found = [name for name, mesh in rig.mesh.items() if _nowhere_coarser(mesh, here) and wanted(mesh)]
        yield from sorted(found, key=lambda name: (size_of(rig, name).unknowns, rig.mesh[name].contact_elements))[:1]

    here = rig.mesh[preset]
    of_contacts = smallest(lambda mesh: mesh.contact_elements > here.contact_elements)
    contacts = {"contact_elements": here.contact_elements, "contact_strips": here.contact_strips}
    of_mesh = smallest(lambda mesh: mesh.model_copy(update=contacts) != here)
    return tuple(dict.fromkeys((*of_mesh, *of_contacts)))


def _nowhere_coarser(mesh: MeshDivisions, than: MeshDivisions) -> bool:
    """Strips of contact elements count where both state them."""
    stated = mesh.model_dump(exclude_none=True)
    return all(stated.get(name, least) >= least for name, least in than.model_dump(exclude_none=True).items())


def _blade_section(mesh: MeshDivisions) -> tuple[int, int]:
    """Quadrilaterals of the blade's section and edges on its outline (geometry/cross_sections.py has the blocks)."""
    stem = (
        mesh.stem_below_excitation
        + mesh.stem_below_platform
        + mesh.platform_height
        + mesh.stem_above_platform
        + mesh.stem_top
    )
    reach = mesh.platform_inner + mesh.face + mesh.platform_outer
    cells = mesh.stem_thickness * stem + mesh.platform_height * reach
    return cells, 2 * (stem + mesh.stem_thickness + reach)


def _damper_section(rig: Rig, mesh: MeshDivisions) -> tuple[int, int]:
    up = mesh.face + mesh.damper_base + (mesh.damper_apex if rig.damper.apex_height > 0 else 0)
    return mesh.damper_across * up, 2 * (mesh.damper_across + up)


def _nodes(cells: int, outline: int, layers: int) -> int:
    """Of 20-node hexahedra over a section without holes: vertices and middles of edges. Edges of the section are
    2 cells + outline / 2, and by Euler's formula its vertices are 1 + edges - cells."""
    edges = 2 * cells + outline // 2
    vertices = 1 + edges - cells
    return (vertices + edges) * (layers + 1) + vertices * layers
