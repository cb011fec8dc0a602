"""The static contact stage on a wedge between two elastic half-space-like blades, its flexibility given in formulas."""

from dataclasses import replace

import numpy as np
import pytest

from updamp.fem.reduced_model import ReducedComponent, ReducedModel
from updamp.fem.static_contact.contact_problem import ContactOptions
from updamp.fem.static_contact.finite_element_pressure import (
    StaticContactError,
    finite_element,
    initial_gap,
    pull_on_ends,
    pull_on_mass,
    solve_along,
    wedge_problem,
)
from updamp.fem.static_contact.rest_state import FaceCoordinates, patch_average
from updamp.fem.static_contact.static_contact import PRESSURE_MODELS, fit_polynomial, static_contact
from updamp.geometry.contact_elements import LEFT, RIGHT, ContactElements
from updamp.model.rig_files import load_rig
from updamp.rig.pressure import SurfaceProfile
from updamp.rig.rig import Contact, Rig

RIG_FILE = "tests/data/early_opening.toml"
WEDGE = {"platform.underside_angle": "45 deg", "blade.width": "60 mm"}  # those of the wedge made here
LENGTH, WIDTH, ANGLE = 8e-3, 60e-3, np.radians(45)
PULL, MU = 960.0, 0.6


def rig_with(**pressure) -> Rig:
    return load_rig(RIG_FILE, WEDGE | {"contact.pressure": pressure})


def faces(across: int = 3, along: int = 6) -> ContactElements:
    """Two mirror-image faces of across x along cells, two triangles each."""
    s = np.linspace(-LENGTH / 2, LENGTH / 2, across + 1)
    z = np.linspace(-WIDTH / 2, WIDTH / 2, along + 1)
    corner = np.stack(np.meshgrid(s, z, indexing="ij"), axis=-1)
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    # Diagonals mirrored about the middle of the damper, so that the mesh has that symmetry too.
    half = along // 2
    first = np.where(np.arange(along)[None, :, None, None] < half, np.stack([a, b, c], 2), np.stack([a, b, d], 2))
    second = np.where(np.arange(along)[None, :, None, None] < half, np.stack([a, c, d], 2), np.stack([b, c, d], 2))
    flat = np.concatenate([first.reshape(-1, 3, 2), second.reshape(-1, 3, 2)])
    up, normal = [-np.cos(ANGLE), np.sin(ANGLE), 0], [np.sin(ANGLE), np.cos(ANGLE), 0]
    middle = np.array([5.5e-3, 33e-3, 0])
    right = middle + flat[..., :1] * np.array(up) + flat[..., 1:] * np.array([0, 0, 1.0])
    mirror = np.array([-1, 1, 1])
    n = len(flat)
    e = np.diff(flat, axis=1)
    area = np.abs(e[:, 0, 0] * e[:, 1, 1] - e[:, 0, 1] * e[:, 1, 0]) / 2

    def both(vector):
        return np.concatenate([np.tile(np.multiply(vector, mirror), (n, 1)), np.tile(vector, (n, 1))]).astype(float)

    triangle = np.concatenate([right * mirror, right])
    return ContactElements(
        face=np.repeat([LEFT, RIGHT], n),
        point=triangle.mean(axis=1),
        area=np.tile(area, 2),
        tangent1=both(up),
        tangent2=both([0, 0, 1.0]),
        normal=both(normal),
        triangle=triangle,
    )


def half_space_like(points: np.ndarray) -> np.ndarray:
    """Boussinesq's 1/r law, made finite at r = 0; positive definite, directions uncoupled. (3 n, 3 n) [m/N]"""
    distance = np.linalg.norm(points[:, None] - points[None], axis=-1)
    return np.kron((1 - 0.3**2) / (np.pi * 197e9) / np.sqrt(distance**2 + 1e-3**2), np.eye(3))


def blade(contacts: ContactElements, side: int) -> ReducedComponent:
    """Local flexibility as residual, and one bending mode that moves the platform sideways and turns it."""
    on = contacts.face == side
    outwards = 1.0 if side == RIGHT else -1.0
    height = contacts.point[on, 1] - 33e-3
    reach = np.abs(contacts.point[on, 0])
    motion = np.column_stack([outwards * (1 + 20 * height), -20 * reach, 0 * reach])
    phi = np.einsum("ndx,nx->nd", contacts.axes[on], motion).ravel()
    points = ("excitation.x", "tip.x", "platform.x", "platform.y")
    phi = np.concatenate([phi, [0.3, 3.0, 1.0, -0.1]]) * 2.5
    residual = np.zeros((len(phi), len(phi)))
    residual[: 3 * on.sum(), : 3 * on.sum()] = half_space_like(contacts.point[on])
    return ReducedComponent("blade", np.array([2 * np.pi * 269]), phi[:, None], residual, points)


def damper(contacts: ContactElements) -> ReducedComponent:
    """Rigid: its six modes with the mass and inertia of a wedge of 40 g."""
    centre = np.array([0, 31e-3, 0])
    ends = [np.array([0, 31e-3, z]) for z in (-WIDTH / 2, WIDTH / 2)]
    corners = [np.array([x, 29e-3, 0]) for x in (-8e-3, 8e-3)]
    scale = 1 / np.sqrt([0.04, 0.04, 0.04, 1.2e-5, 1.3e-5, 1e-6])

    def motion(point):
        arm = point - centre
        return np.hstack([np.eye(3), np.array([np.cross(axis, arm) for axis in np.eye(3)]).T]) * scale

    local = np.vstack([axes @ motion(point) for axes, point in zip(contacts.axes, contacts.point, strict=True)])
    rows = [motion(p)[:2] for p in corners] + [motion(p) for p in ends]
    names = tuple(f"corner_{s}.{d}" for s in ("left", "right") for d in "xy")
    names += tuple(f"wire_{s}.{d}" for s in ("back", "front") for d in "xyz")
    phi = np.vstack([local, *rows])
    return ReducedComponent("damper", np.zeros(6), phi, np.zeros((len(phi), len(phi))), names)


@pytest.fixture(scope="module")
def wedge() -> ReducedModel:
    contacts = faces()
    return ReducedModel(blade(contacts, LEFT), blade(contacts, RIGHT), damper(contacts), contacts, 0.0)


def resultant(contacts: ContactElements, rest) -> np.ndarray:
    """Force and moment about (0, 31 mm, 0) of the platforms on the damper: -f. (6,) [N], [N m]"""
    local = np.column_stack([rest.tangential_force, rest.normal_force])
    force = -np.einsum("nd,ndx->nx", local, contacts.axes)
    arm = contacts.point - [0, 31e-3, 0]
    return np.concatenate([force.sum(axis=0), np.cross(arm, force).sum(axis=0)])


SHAPES = [
    {"model": "uniform"},
    {"model": "two_area", "central_share": 0.8, "central_fraction": 0.45},
    {"model": "two_area", "central_share": 1.0, "central_fraction": 0.3},
    {"model": "polynomial", "coefficients": [[1.0, 0.1, -0.8], [0.3], [-0.5]]},
    {
        "model": "by_face",
        "left": {"model": "uniform"},
        "right": {"model": "two_area", "central_share": 0.9, "central_fraction": 0.4},
    },
]


@pytest.mark.parametrize("shape", SHAPES)
def test_prescribed_pressure_carries_the_pull(wedge: ReducedModel, shape) -> None:
    rest = static_contact(wedge, rig_with(**shape))
    eq5 = PULL / (2 * (np.cos(ANGLE) + MU * np.sin(ANGLE)))
    for side in (LEFT, RIGHT):
        assert rest.normal_force[wedge.contacts.face == side].sum() == pytest.approx(eq5, rel=1e-13)
    assert rest.model == shape["model"]
    assert rest.applied == PULL
    assert rest.normal_total == pytest.approx(2 * eq5, rel=1e-13)
    assert rest.equilibrium_error < 1e-13
    assert rest.normal_force.min() >= 0
    assert np.all(rest.tangential_force[:, 0] == MU * rest.normal_force)
    assert not rest.tangential_force[:, 1].any()
    assert not rest.gap.any()
    force = resultant(wedge.contacts, rest)[:3]
    assert force == pytest.approx([0, -PULL, 0], abs=1e-10 * PULL)  # the contacts hold the damper down


def test_uniform_is_uniform(wedge: ReducedModel) -> None:
    rest = static_contact(wedge, rig_with(model="uniform"))
    sigma0 = PULL / (2 * LENGTH * WIDTH * (np.cos(ANGLE) + MU * np.sin(ANGLE)))
    assert rest.normal_force / wedge.contacts.area == pytest.approx(sigma0, rel=1e-12)


def test_each_face_has_the_pressure_that_is_stated_for_it(wedge: ReducedModel) -> None:
    shape = {"model": "two_area", "central_share": 0.9, "central_fraction": 1 / 3}
    left_alone, right_alone = static_contact(wedge, rig_with(model="uniform")), static_contact(wedge, rig_with(**shape))
    rest = static_contact(wedge, rig_with(model="by_face", left={"model": "uniform"}, right=shape))
    left = wedge.contacts.face == LEFT
    assert np.array_equal(rest.normal_force[left], left_alone.normal_force[left])
    assert np.array_equal(rest.normal_force[~left], right_alone.normal_force[~left])
    assert np.ptp(rest.normal_force[~left] / wedge.contacts.area[~left]) > 0


def test_wrong_angle_of_the_rig_file_is_seen_in_the_equilibrium(wedge: ReducedModel) -> None:
    rig = load_rig(RIG_FILE, WEDGE | {"platform.underside_angle": "46 deg"})
    assert static_contact(wedge, rig).equilibrium_error > 1e-3


@pytest.mark.parametrize(("share", "fraction"), [(0.7, 0.5), (0.9, 1 / 3), (0.8, 0.41), (0.0, 0.2)])
def test_two_area_shares_hold_on_any_mesh(share: float, fraction: float) -> None:
    """A strip that cuts patches: the pressure is constant where patches are whole, and shares hold in total."""
    contacts = faces(2, 10)
    model = ReducedModel(blade(contacts, LEFT), blade(contacts, RIGHT), damper(contacts), contacts, 0.0)
    rest = static_contact(model, rig_with(model="two_area", central_share=share, central_fraction=fraction))
    face = PULL / (2 * (np.cos(ANGLE) + MU * np.sin(ANGLE)))
    half = fraction * WIDTH / 2
    inside = np.all(np.abs(contacts.triangle[:, :, 2]) <= half + 1e-12, axis=1)
    outside = np.all(np.abs(contacts.triangle[:, :, 2]) >= half - 1e-12, axis=1)
    pressure = rest.normal_force / contacts.area
    round_off = 1e-13 * face / (LENGTH * WIDTH)
    for patches, part, size in ((inside, share, fraction), (outside, 1 - share, 1 - fraction)):
        assert pressure[patches] == pytest.approx(part * face / (size * LENGTH * WIDTH), rel=1e-12, abs=round_off)
    assert 0 < inside.sum() < len(contacts)
    assert 0 < outside.sum() < len(contacts)


def test_polynomial_average_is_exact_and_clipped(wedge: ReducedModel) -> None:
    """p = 1 - 2 z^2 is negative beyond |z| = 0.7071; face force against the clipped integral."""
    rest = static_contact(wedge, rig_with(model="polynomial", coefficients=[[1.0, 0.0, -2.0]]))
    z = np.abs(wedge.contacts.triangle[:, :, 2]) / (WIDTH / 2)
    far, near = np.all(z >= 0.7072, axis=1), np.all(z <= 0.34, axis=1)
    assert rest.normal_force.min() >= 0
    assert np.all(rest.normal_force[far] == 0)
    integral = 2 * (1 / 3 - 2 / 3 / 27)  # of 1 - 2 z^2 over |z| < 1/3
    clipped = 2 * (0.5**0.5 - 2 / 3 * 0.5**1.5)
    assert rest.normal_force[near].sum() / rest.normal_total == pytest.approx(integral / clipped, rel=2e-3)


def test_patch_average_is_exact_to_fourth_order(wedge: ReducedModel) -> None:
    coordinates = FaceCoordinates.of(wedge.contacts)
    mean = patch_average(coordinates, lambda s, z: (s / LENGTH) ** 2 * (z / WIDTH) ** 2 + (z / WIDTH) ** 4)
    right = wedge.contacts.face == RIGHT
    total = np.sum(mean[right] * wedge.contacts.area[right]) / (LENGTH * WIDTH)
    assert total == pytest.approx(1 / 12 / 12 + 1 / 80, rel=1e-13)


def test_scanned_map_gives_the_polynomial_it_was_made_from(wedge: ReducedModel, tmp_path) -> None:
    table = [[2.0, 0.1, -0.8, 0.0, -0.3], [0.3, 0.2], [-0.5, 0.0, 0.1], [0.1], [0.05]]
    grid = np.array([(s, z) for s in np.linspace(-1, 1, 9) for z in np.linspace(-1, 1, 13)])
    padded = np.array([row + [0.0] * (5 - len(row)) for row in table])
    pressure = np.polynomial.polynomial.polyval2d(grid[:, 0], grid[:, 1], padded)
    rows = "\n".join(f"{s!r},{z!r},{p!r}" for s, z, p in np.column_stack([grid, pressure]).tolist())
    (tmp_path / "film.csv").write_text(f"s,z,pressure\n{rows}\n")
    scanned = static_contact(wedge, rig_with(model="polynomial", map=str(tmp_path / "film.csv")))
    given = static_contact(wedge, rig_with(model="polynomial", coefficients=table))
    assert scanned.normal_force == pytest.approx(given.normal_force, rel=1e-10)


def test_scan_along_one_line_is_refused() -> None:
    with pytest.raises(ValueError, match=r"40 samples determine only 5 of the 15 coefficients"):
        fit_polynomial([(0.3, z, 1.0) for z in np.linspace(-1, 1, 40)])


def test_every_pressure_model_of_the_rig_file_is_in_the_registry() -> None:
    union = Contact.model_fields["pressure"].annotation
    assert set(PRESSURE_MODELS) == set(union.__args__)


FRICTION = [{"friction": False}, {"friction": True}]
PROFILES = [{}, {"crown_height": "5 um"}, {"tilt": "0.005 deg"}, {"edge_rounding": "0.5 mm"}, {"crown_radius": "0.5 m"}]


@pytest.mark.parametrize("friction", FRICTION)
@pytest.mark.parametrize("profile", PROFILES)
def test_unilateral_wedge_is_in_equilibrium_and_complementary(wedge: ReducedModel, friction, profile) -> None:
    rest = static_contact(wedge, rig_with(model="fe", **friction, profile=profile))
    assert rest.equilibrium_error < 1e-10
    pull = np.array([0, PULL, 0, 0, 0, 0])
    error = np.abs(resultant(wedge.contacts, rest) + pull)
    assert error[:3].max() < 1e-10 * PULL
    assert error[3:].max() < 1e-10 * PULL * WIDTH
    assert rest.normal_force.min() >= 0
    assert rest.gap.min() >= 0
    assert not np.any(rest.normal_force * rest.gap)
    if friction["friction"]:
        limit = MU * rest.normal_force[:, None]
        assert np.all(np.abs(rest.tangential_force) <= limit * (1 + 1e-9))
        assert rest.tangential_force[:, 0].sum() > 0  # friction holds the damper back
    else:
        assert not rest.tangential_force.any()
        assert rest.normal_total == pytest.approx(PULL / np.cos(ANGLE), rel=1e-10)


@pytest.mark.parametrize("friction", FRICTION)
def test_symmetric_wedge_rests_symmetrically(wedge: ReducedModel, friction) -> None:
    rest = static_contact(wedge, rig_with(model="fe", **friction))
    left, right = (wedge.contacts.face == side for side in (LEFT, RIGHT))
    assert rest.normal_force[left] == pytest.approx(rest.normal_force[right], abs=1e-10 * PULL)
    assert rest.tangential_force[left] == pytest.approx(rest.tangential_force[right], abs=1e-10 * PULL)
    back = rest.normal_force[wedge.contacts.point[:, 2] < 0].sum()
    assert back == pytest.approx(rest.normal_total / 2, rel=1e-9)


def test_surface_profile_moves_the_pressure_as_it_should() -> None:
    """A crown carries in the middle of the slope, rounded edges off the edges."""
    contacts = faces(6, 4)
    fine = ReducedModel(blade(contacts, LEFT), blade(contacts, RIGHT), damper(contacts), contacts, 0.0)
    plane, crowned, rounded = (
        static_contact(fine, rig_with(model="fe", profile=profile)).normal_force
        for profile in ({}, {"crown_height": "20 um"}, {"edge_rounding": "0.5 mm"})
    )
    from_middle = np.abs(FaceCoordinates.of(contacts).slope.mean(axis=1))
    edge = from_middle > 0.42 * LENGTH  # patches that touch the upper or the lower edge with a side

    def mean_distance(force):
        return np.sum(force * from_middle) / force.sum()

    assert mean_distance(crowned) < 0.5 * mean_distance(plane)
    assert rounded[edge].sum() < 0.5 * plane[edge].sum()
    assert mean_distance(rounded) < mean_distance(plane)


def test_damper_turns_until_tilted_faces_fit(wedge: ReducedModel) -> None:
    """A tilt alone is a rotation of the whole damper, which floats: without friction it changes no force."""
    plane, tilted = (
        static_contact(wedge, rig_with(model="fe", friction=False, profile=profile))
        for profile in ({}, {"tilt": "0.05 deg"})
    )
    assert tilted.normal_force == pytest.approx(plane.normal_force, abs=1e-9 * PULL)


def test_initial_gap_of_each_profile(wedge: ReducedModel) -> None:
    coordinates = FaceCoordinates.of(wedge.contacts)
    area = wedge.contacts.area / wedge.contacts.area.sum()

    def mean_gap(**profile):
        return np.sum(area * initial_gap(coordinates, SurfaceProfile.model_validate(profile)))

    assert mean_gap() == 0
    assert mean_gap(crown_height="6 um") == pytest.approx(2e-6, rel=1e-12)
    assert mean_gap(crown_radius="2 m") == pytest.approx(LENGTH**2 / 12 / 4, rel=1e-12)
    assert mean_gap(tilt="-0.01 deg") == pytest.approx(np.tan(np.radians(0.01)) * WIDTH / 2, rel=1e-12)
    assert mean_gap(edge_rounding="1 mm") == pytest.approx(2 * 1e-3**2 / 6 / LENGTH, rel=0.01)


def test_without_gap_one_load_step_is_as_good_as_many(wedge: ReducedModel) -> None:
    problem = wedge_problem(wedge, np.zeros(len(wedge.contacts)), MU)
    load, free = pull_on_ends(wedge.damper, PULL)
    one, many = (solve_along(problem, load, free, steps, ContactOptions()).value[-1] for steps in (1, 7))
    assert many.force == pytest.approx(one.force, abs=1e-9 * PULL)


def test_pushing_instead_of_pulling_is_a_named_error(wedge: ReducedModel) -> None:
    problem = wedge_problem(wedge, np.zeros(len(wedge.contacts)), MU)
    load, free = pull_on_ends(wedge.damper, PULL)
    with pytest.raises(StaticContactError, match=r"load step 1 of 1 .* the contacts cannot carry the load"):
        solve_along(problem, -load, -free, 1, ContactOptions())


def test_too_few_iterations_is_a_named_error_that_says_what_to_try(wedge: ReducedModel) -> None:
    rig = rig_with(model="fe", profile={"crown_height": "50 um"})
    with pytest.raises(StaticContactError, match=r"load step 1 of 20 after 3 iterations .* then try more load steps"):
        finite_element(wedge, rig, ContactOptions(max_iterations=1, direct_iterations=1, friction_cycles=1))


def test_damper_without_rigid_modes_is_a_named_error(wedge: ReducedModel) -> None:
    held = replace(wedge, damper=replace(wedge.damper, omega=np.ones(6)))
    with pytest.raises(StaticContactError, match="0 modes with a frequency of exactly 0, where 6 are expected"):
        wedge_problem(held, np.zeros(len(wedge.contacts)), MU)


def test_pull_on_the_mass_is_the_pull_on_the_ends_of_a_rigid_damper(wedge: ReducedModel) -> None:
    """The ends lie level with the centre of mass here, and nothing bends."""
    for pull_on in (pull_on_ends, pull_on_mass):
        load, free = pull_on(wedge.damper, PULL)
        assert load == pytest.approx([0, PULL / np.sqrt(0.04), 0, 0, 0, 0], abs=1e-9 * PULL)
        assert not free.any()
