"""Pressure from unilateral contact, with or without friction, on the compliance of blades and damper.

The damper's faces may deviate from planes by a stated profile, which is the initial gap of the contact patches.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from updamp.fem.reduced_model import ReducedComponent, ReducedModel
from updamp.fem.static_contact.contact_problem import ContactOptions, ContactProblem, ContactSolution, ContactStatus
from updamp.fem.static_contact.rest_state import FaceCoordinates, StaticContact, patch_average, rest_state
from updamp.fem.static_contact.unilateral_contact import solve_unilateral_contact
from updamp.rig.pressure import FePressure, SurfaceProfile
from updamp.rig.rig import Rig

Floats = NDArray[np.float64]


def initial_gap(coordinates: FaceCoordinates, profile: SurfaceProfile) -> Floats:
    """(n,) patch averages of the gap [m], the same on both faces; 0 everywhere for plane faces.

    crown:         min(s^2 / (2 R), height), s from the middle of the face up its slope
    tilt:          tan(tilt) times the distance from the end of the damper that stands out; a damper that floats
                   turns until such faces fit, so that the tilt acts only through the path of friction
    edge_rounding: (r - d)^2 / (2 r) within the distance d < r of the upper and of the lower edge
    """
    half_length, half_width = coordinates.length[:, None] / 2, coordinates.width[:, None] / 2
    crown = profile.crown(float(coordinates.length.max()))
    radius = profile.edge_rounding

    def gap(s: Floats, z: Floats) -> Floats:
        opening = np.tan(profile.tilt) * z + abs(np.tan(profile.tilt)) * half_width
        if crown is not None:
            opening = opening + np.minimum(s**2 / (2 * crown[1]), crown[0])
        if radius > 0:
            opening = opening + np.maximum(radius - (half_length - np.abs(s)), 0.0) ** 2 / (2 * radius)
        return opening

    return patch_average(coordinates, gap)


LOAD_STEPS = 20  # with friction and a gap; without a gap all is proportional to the load, and one step is exact
ENDS = ("back", "front")
WIRES = tuple(f"wire_{end}.y" for end in ENDS)

Pull = Callable[[ReducedComponent, float], tuple[Floats, Floats]]


class StaticContactError(RuntimeError):
    """The static contact problem has no solution, or none was found; the message says what to try."""


def pull_on_ends(damper: ReducedComponent, pull: float) -> tuple[Floats, Floats]:
    """The wires' pull [N], vertical, half spread over each end face. The wires' own stiffness plays no part: they carry
    the pull whatever they stretch.

    returns: load on the rigid-body modes, and the elastic displacement (n_contact_dofs,) [m] that it gives by itself
    """
    external = np.zeros(len(damper.residual))
    for name in WIRES:
        external[damper.n_contact_dofs + damper.points.index(name)] = pull / len(WIRES)
    free = elastic_flexibility(damper) @ external
    return damper.phi[:, damper.omega == 0].T @ external, free[: damper.n_contact_dofs]


def pull_on_mass(damper: ReducedComponent, pull: float) -> tuple[Floats, Floats]:
    """The pull [N] as a body force along y, as the centrifugal load of an engine acts.

    A uniform acceleration loads the rigid-body modes alone, for elastic modes are mass-orthogonal to them; the
    wires' points only tell which of their combinations is the motion along y (that moves both ends alike, and in y).
    """
    rigid = damper.phi[:, damper.omega == 0]
    ends = [damper.n_contact_dofs + damper.points.index(f"wire_{end}.{axis}") for end in ENDS for axis in "xyz"]
    sides = [damper.n_contact_dofs + damper.points.index(f"corner_{side}.y") for side in ("left", "right")]
    along_y = np.tile([0.0, 1.0, 0.0], len(ENDS))
    motion = np.linalg.lstsq(rigid[ends + sides], np.concatenate([along_y, np.ones(2)]), rcond=None)[0]
    # Mass-normalised modes: the load a M e_y of total force `pull` has these modal amplitudes times the acceleration.
    return motion * pull / (motion @ motion), np.zeros(damper.n_contact_dofs)


PULLS: Mapping[str, Pull] = MappingProxyType({"ends": pull_on_ends, "mass": pull_on_mass})  # by `pull_on` of the file


def finite_element(reduced: ReducedModel, rig: Rig, options: ContactOptions | None = None) -> StaticContact:
    """Rest state of the damper pulled up against both platforms.

    Where the pull acts (`pull_on`) matters: on the ends it bends a slender damper, which then bears near its ends.
    Faces are in rigid unilateral contact (no layer of contact stiffness: the only compliance is that of the bodies,
    modes and residual). Without friction nothing holds the damper along z; it then keeps its place there (least
    rigid motion). Friction is limited in each direction by itself, whatever contact.law says (rig/questions.py asks).

    raises: StaticContactError if the contact problem is not solved
    """
    model = rig.contact.pressure
    assert isinstance(model, FePressure)
    friction = rig.contact.friction_coefficient if model.friction else 0.0
    gap = initial_gap(FaceCoordinates.of(reduced.contacts), model.profile)
    problem = wedge_problem(reduced, gap, friction)
    load, free = PULLS[model.pull_on](reduced.damper, rig.load.pull)
    steps = LOAD_STEPS if friction > 0 and np.any(gap > 0) else 1
    solution = solve_along(problem, load, free, steps, options or ContactOptions())
    state = solution.value[-1]
    return rest_state(
        model.model, reduced.contacts, np.maximum(state.force[:, 2], 0.0), state.force[:, :2],
        np.maximum(state.opening, 0.0), rig.load.pull,
    )  # fmt: skip


def solve_along(
    problem: ContactProblem, load: Floats, free: Floats, steps: int, options: ContactOptions
) -> ContactSolution:
    """Proportional loading in equal steps. raises: StaticContactError unless every step converges."""
    parts = np.arange(1, steps + 1)[:, None] / steps
    solution = solve_unilateral_contact(problem, parts * load, parts * free, options)
    if solution.status is not ContactStatus.CONVERGED:
        reached = len(solution.value)
        raise StaticContactError(
            f"static contact, load step {reached + 1} of {steps} after {solution.iterations[-1]} iterations "
            f"(largest violation {solution.residuals[-1]:.1e}): {solution.status.value}"
        )
    return solution


def wedge_problem(reduced: ReducedModel, gap: Floats, friction: float) -> ContactProblem:
    """The contact problem of the floating damper between both blades. gap: (n,) [m]

    raises: StaticContactError if a blade floats or the damper has no six rigid-body modes
    """
    _check_rigid_modes(reduced)
    n = len(reduced.contacts)
    flexibility = np.zeros((3 * n, 3 * n))
    for component, rows in zip(reduced.components, reduced.contact_rows(), strict=True):
        flexibility[np.ix_(rows, rows)] += elastic_flexibility(component)[: len(rows), : len(rows)]
    rigid = reduced.damper.phi[: 3 * n, reduced.damper.omega == 0]
    return ContactProblem((flexibility + flexibility.T) / 2, rigid, gap, np.full(n, friction))


def elastic_flexibility(component: ReducedComponent) -> Floats:
    """(n_interface, n_interface) [m/N] of the elastic modes and the residual; rigid-body modes are left out."""
    elastic = component.omega > 0
    scaled = component.phi[:, elastic] / component.omega[elastic]
    return scaled @ scaled.T + component.residual


def _check_rigid_modes(reduced: ReducedModel) -> None:
    for component, wanted in zip(reduced.components, (0, 0, 6), strict=True):
        found = int(np.sum(component.omega == 0))
        if found != wanted:
            raise StaticContactError(
                f"{component.name} has {found} modes with a frequency of exactly 0, where {wanted} are expected; "
                f"the blades are clamped and the damper floats: check the reduction"
            )
