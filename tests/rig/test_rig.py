"""The rig file: what is read, and what is refused in which words."""

import math
import tomllib
from pathlib import Path

import pytest
from pydantic import ValidationError
from pydantic_core import to_json

from updamp.model.rig_files import load_rig
from updamp.rig.errors import RigError
from updamp.rig.fields import Quantity
from updamp.rig.pressure import FePressure, PolynomialPressure, SurfaceProfile, TwoAreaPressure
from updamp.rig.rig import Rig

REFERENCE = Path(__file__).parents[2] / "rigs" / "pesaresi2017.toml"

# Dimensions of these tests' own, so that the reference rig may be fitted again without touching them.
SECTION = {
    "blade": {"height": "150 mm", "thickness": "7.3 mm", "width": "60 mm", "axis_offset": "18 mm"},
    "platform": {"top": "46 mm", "gap": "4 mm", "edge_thickness": "9 mm", "underside_angle": "45 deg"},
    "damper": {
        "face_start": "1 mm",
        "face_length": "8 mm",
        "apex_height": "0.5 mm",
        "apex_flat": "3 mm",
        "base_height": "1 mm",
    },
    "excitation": {"blade": "right", "height": "20 mm"},
    "response.below_top": "20 mm",
}


def load(**overrides: object) -> Rig:
    """The reference rig with this section; keys with __ for dots."""
    return load_rig(REFERENCE, SECTION | {key.replace("__", "."): value for key, value in overrides.items()})


def problems(**overrides: object) -> list[str]:
    with pytest.raises(RigError) as caught:
        load(**overrides)
    first, *lines = str(caught.value).splitlines()
    assert first == f"{REFERENCE}:"
    return lines


def test_reference_rig_loads_with_exactly_the_keys_of_the_file() -> None:
    def keys(table: object) -> object:
        return {key: keys(value) for key, value in table.items()} if isinstance(table, dict) else None

    rig = load_rig(REFERENCE)
    assert keys(rig.model_dump(exclude={"effects", "calibration"}, exclude_none=True)) == keys(
        tomllib.loads(REFERENCE.read_text())
    )
    assert rig.effects == ()
    assert not rig.calibration
    assert rig.name == "pesaresi2017"
    assert {"small", "full"} <= set(rig.mesh)
    assert rig.mesh["full"].contact_elements == 146
    assert rig.study.force_levels == (0.096, 0.96, 3.84, 9.6, 17.0)
    assert rig.harmonic_balance.harmonics == (0, 1, 2, 3)


def test_quantities_become_si() -> None:
    rig = load(
        material__youngs_modulus="197 GPa",
        contact__normal_stiffness="60000 N/mm^3",
        contact__tangential_stiffness="60 N/um/mm^2",
        study__modes__OOP__window=["0.434 kHz", "446 1/s"],
        load__pull="0.96 kN",
        blade__height="15 cm",
        material__density="7.8 g/cm^3",
    )
    assert rig.material.youngs_modulus == 197e9
    assert rig.contact.normal_stiffness == rig.contact.tangential_stiffness == 6e13
    assert rig.study.modes["OOP"].window == (434.0, 446.0)
    assert rig.load.pull == 960.0
    assert rig.blade.height == 0.15
    assert rig.material.density == 7800.0
    assert rig.platform.underside_angle == pytest.approx(math.pi / 4, rel=1e-15)


def test_automatic_harmonics_begin_with_the_first_ones_and_have_a_tolerance() -> None:
    stated, automatic = load(), load(harmonic_balance__harmonics="auto")
    assert stated.harmonic_balance.tolerance is None
    assert automatic.harmonic_balance.harmonics == (0, 1, 2, 3)
    assert automatic.harmonic_balance.tolerance == 0.01
    given = load(harmonic_balance__harmonics="auto", harmonic_balance__tolerance=0.05)
    assert given.harmonic_balance.tolerance == 0.05
    assert len({rig.digest("harmonic_balance") for rig in (stated, automatic, given)}) == 3
    assert b"tolerance" not in to_json(stated.harmonic_balance), "what was stored before the key existed still holds"


def test_derived_dimensions() -> None:
    rig = load()
    reach = 18e-3 - 7.3e-3 / 2 - 2e-3
    assert rig.underside_length == pytest.approx(reach * math.sqrt(2))
    assert rig.junction_height == pytest.approx(37e-3 - reach)
    assert rig.underside_point(0.0) == pytest.approx((2e-3, 37e-3))
    assert rig.underside_point(rig.underside_length) == pytest.approx((14.35e-3, rig.junction_height))
    assert rig.face_top == pytest.approx((2e-3 + 1e-3 / math.sqrt(2), 37e-3 - 1e-3 / math.sqrt(2)))
    assert rig.face_bottom == pytest.approx((2e-3 + 9e-3 / math.sqrt(2), 37e-3 - 9e-3 / math.sqrt(2)))
    assert rig.face_area == pytest.approx(480e-6)
    assert rig.response_height == pytest.approx(0.13)


QUANTITIES = [
    (150, 'state its unit as text, such as "150 mm"'),
    (0.15, 'state its unit as text, such as "150 mm"'),
    ("150", 'state its unit, such as "150 mm"'),
    ("150 kg", 'wrong dimension: needs a unit of the kind m, such as "150 mm"'),
    ("150 mm rad", "wrong dimension"),
    ("150 mmm", 'unknown unit "mmm"; write it like "150 mm"'),
    ("150 mm^", 'unknown unit "mm^"'),
    ("1 E:0^0", "unknown unit"),
    ("3 dB", '"dB" is logarithmic; give values as they are (an amplitude is 10^(dB/20) of its reference)'),
    ("3 octave", '"octave" is logarithmic'),
    ("3 Np", '"Np" is logarithmic'),
    ("3 dB/s", '"dB/s" is logarithmic'),
    ("mm", "not a number with a unit"),
    (True, "not a number with a unit"),
    ("nan mm", "not a finite number"),
    ("-inf mm", "not a finite number"),
    ("1e400 mm", "not a finite number"),
    ("-3 mm", "out of range: allowed is at least 0.001 mm and at most 10000 mm"),
    ("0 mm", "out of range: allowed is at least 0.001 mm"),
    ("150 km", "out of range"),
]


@pytest.mark.parametrize(("value", "words"), QUANTITIES)
def test_bad_quantity(value: object, words: str) -> None:
    (line,) = problems(blade__height=value)
    assert line.startswith("blade.height = ")
    assert str(value).lower() in line.lower()
    assert words in line


@pytest.mark.parametrize("text", ["45 %", "45", "45 m/m"])
def test_angle_needs_a_unit_of_angle(text: str) -> None:
    (line,) = problems(platform__underside_angle=text)
    assert line.startswith(f'platform.underside_angle = "{text}": ')
    assert '"45 deg"' in line


def test_angular_frequency_is_not_taken_for_a_frequency() -> None:
    (line,) = problems(study__modes__IP__window=["370 Hz", "2700 rad/s"])
    assert line == (
        'study.modes.IP.window[1] = "2700 rad/s": wrong dimension: needs a unit of the kind Hz, such as "430 Hz"'
    )


def test_decimal_reading_leaves_no_round_off() -> None:
    assert Quantity("m", "5 mm").to_si("18 mm") == 0.018
    assert Quantity("rad", "5 deg", at_most=80).to_si("80 deg") == pytest.approx(math.radians(80), rel=1e-15)


KEYS = [
    ({"blade__heigth": "3 mm"}, 'blade.heigth = "3 mm": unknown key; did you mean height?'),
    ({"mesh__full__widht": 4}, "mesh.full.widht = 4: unknown key; did you mean width?"),
    ({"colour": "red"}, 'colour = "red": unknown key; allowed are name, damper_model, material'),
    ({"contact__pressure__share": 1}, "contact.pressure.share = 1: unknown key; allowed are model"),
    ({"blade": {**SECTION["blade"], "height": 1}}, "blade.height = 1: state its unit"),
    ({"wire": {"length": "1 m", "axial_stiffness": "1e6 N/m"}}, "wire.attachment_height: missing; add it, such as"),
    ({"wire": 3}, "wire = 3: a table of keys is wanted, [wire]"),
    ({"mesh": 3}, "mesh = 3: a table of keys is wanted, [mesh]"),
    ({"mesh": {}}, "mesh = {}: entries wanted: at least 1; add a table [mesh.NAME] with width"),
    ({"name": "a b"}, 'name = "a b": a name is a letter, then'),
    ({"excitation__blade": "middle"}, 'excitation.blade = "middle": should be "left" or "right"'),
    ({"contact__law": "coulomb"}, 'contact.law = "coulomb": should be "jenkins_box"'),
    ({"contact__coupling": "mortar"}, 'contact.coupling = "mortar": should be "patch" or "nearest_node"'),
    ({"reduction__solver": "lu"}, 'reduction.solver = "lu": should be "pardiso", "cholmod" or "amg"'),
    ({"reduction__modes": 0}, "reduction.modes = 0: should be greater than or equal to 1, such as 24"),
    ({"reduction__modes": "24"}, 'reduction.modes = "24": should be a valid integer, such as 24'),
    ({"reduction__modes": True}, "reduction.modes = true: should be a valid integer"),
    ({"material__poissons_ratio": 0.5}, "material.poissons_ratio = 0.5: should be less than or equal to 0.49"),
    ({"material__loss_factor": -0.1}, "material.loss_factor = -0.1: should be greater than or equal to 0"),
    ({"contact__friction_coefficient": math.nan}, "contact.friction_coefficient = NaN: should be"),
    ({"load__pull": "-960 N"}, 'load.pull = "-960 N": out of range: allowed is above 0 N'),
    ({"contact__normal_stiffness": "6e4 N/mm"}, "contact.normal_stiffness"),
    ({"study__force_levels": []}, 'study.force_levels = []: entries wanted: at least 1, such as ["0.96 N", "17 N"]'),
    ({"study__force_levels": "3 N"}, 'force_levels = "3 N": a list in square brackets is wanted, such as ["0.96 N"'),
    ({"study__modes__IP__window": ["1 Hz", "2 Hz", "3 Hz"]}, "entries wanted: at most 2, such as"),
    ({"name": 3}, "name = 3: text in quotes is wanted"),
    ({"study__force_levels": ["1 N", "0 N"]}, 'study.force_levels[1] = "0 N": out of range: allowed is above 0 N'),
    ({"study__force_levels": ["1 N", "1000 mN"]}, "each force level is stated once"),
    ({"study__modes__IP__window": ["432 Hz", "370 Hz"]}, "study.modes.IP.window"),
    ({"study__modes__IP__window": ["432 Hz"]}, "study.modes.IP.window[1]: missing; another entry is wanted"),
    ({"harmonic_balance__harmonics": [0, 2]}, "harmonic_balance.harmonics = [0, 2]: must contain 1"),
    ({"harmonic_balance__harmonics": [1, 1]}, "harmonic_balance.harmonics = [1, 1]: must increase, each stated once"),
    ({"harmonic_balance__harmonics": [0, 1, -2]}, "harmonic_balance.harmonics[2] = -2: should be greater"),
    ({"harmonic_balance__harmonics": [0, 1, 2.5]}, "harmonic_balance.harmonics[2] = 2.5: should be a valid integer"),
    (
        {"harmonic_balance__harmonics": "automatic"},
        'harmonics = "automatic": state a list such as [0, 1, 2, 3], or "auto"',
    ),
    ({"harmonic_balance__tolerance": 0.01}, 'tolerance = 0.01: goes with harmonics = "auto" alone'),
    ({"harmonic_balance__harmonics": "auto", "harmonic_balance__tolerance": 0.0}, "harmonic_balance.tolerance = 0.0"),
    ({"harmonic_balance__time_samples": 6}, "harmonic_balance.time_samples = 6: must be above 6, twice the highest"),
    ({"harmonic_balance__cycles": 1}, "harmonic_balance.cycles = 1: should be greater than or equal to 2"),
    ({"mesh__small__width": 3}, "mesh.small.width = 3: should be a multiple of 2"),
    ({"mesh__small__face": 0}, "mesh.small.face = 0: should be greater than or equal to 1"),
    ({"mesh__small__contact_elements": 2}, "mesh.small.contact_elements = 2: should be greater than or equal to 4"),
    ({"mesh__small__contact_elements": 7}, "mesh.small.contact_elements = 7: should be a multiple of 2"),
    ({"mesh__small__contact_strips": 0}, "mesh.small.contact_strips = 0: should be greater than or equal to 1"),
    ({"mesh__small__contact_strips": 19}, "contact_strips = 19: 72 contact elements make at most 18 on either face"),
]


@pytest.mark.parametrize(("overrides", "words"), KEYS)
def test_bad_key_or_value(overrides: dict[str, object], words: str) -> None:
    (line,) = problems(**overrides)
    assert line.startswith(words) or (line.startswith(next(iter(overrides)).replace("__", ".")) and words in line)


GEOMETRY = [
    ("blade__thickness", "-7 mm", "out of range: allowed is at least 0.001 mm"),
    ("platform__underside_angle", "85 deg", "out of range: allowed is at least 15 deg and at most 80 deg"),
    ("platform__underside_angle", "14.9 deg", "out of range: allowed is at least 15 deg and at most 80 deg"),
    ("damper__face_length", "17 mm", "wider (29.4558 mm) than the space between the blades (28.7 mm)"),
    ("damper__face_length", "17 mm", "allowed is less than 16.4655 mm"),
    ("damper__face_start", "18 mm", "the faces do not touch; the platform's underside is only 17.4655 mm long"),
    ("blade__axis_offset", "5.6 mm", "which needs more than thickness / 2 + gap / 2 = 5.65 mm"),
    ("platform__top", "150 mm", "must be below the blade's tip, 150 mm"),
    ("platform__edge_thickness", "46 mm", "must be less than the height of the platform's top, 46 mm"),
    ("platform__top", "21 mm", "the underside would reach below the root (to -0.35 mm); allowed is more than 41.35 mm"),
    ("excitation__height", "24.7 mm", "must be below the junction of the platform's underside and the stem, 24.65 mm"),
    ("response__below_top", "104 mm", "must be above the platform, so less than 104 mm below the blade's top"),
    ("damper__apex_height", "1.3 mm", "the apex would enter the platforms; allowed is less than 1.20711 mm"),
    ("damper__apex_flat", "5.5 mm", "less than the width at the upper end of the faces, 5.41421 mm"),
    ("damper__base_height", "31 mm", "the damper would reach below the root; allowed is less than 30.636 mm"),
]


@pytest.mark.parametrize(("key", "value", "words"), GEOMETRY)
def test_geometry_that_cannot_be_built(key: str, value: str, words: str) -> None:
    (line,) = problems(**{key: value})
    assert line.startswith(key.replace("__", "."))
    assert value in line
    assert words in line


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("damper__face_length", "16.4 mm"),
        ("damper__apex_height", "1.2 mm"),
        ("damper__apex_height", "0 mm"),
        ("excitation__height", "24.6 mm"),
        ("response__below_top", "103.9 mm"),
        ("platform__underside_angle", "46 deg"),
    ],
)
def test_geometry_just_within_the_bounds(key: str, value: str) -> None:
    load(**{key: value})


def test_without_apex_part_its_flat_has_no_meaning() -> None:
    assert load(damper__apex_height="0 mm", damper__apex_flat="50 mm").damper.apex_height == 0.0


def test_all_problems_are_listed() -> None:
    lines = problems(blade__height="150", load__pul="1 N", mesh__small__face=0)
    assert [line.split(" ")[0] for line in lines] == ["blade.height", "load.pul", "mesh.small.face"]
    lines = problems(excitation__height="30 mm", damper__face_length="17 mm")
    assert [line.split(" ")[0] for line in lines] == ["excitation.height", "damper.face_length"]


def test_nothing_can_be_changed() -> None:
    with pytest.raises(ValidationError, match="frozen"):
        load().blade.height = 0.2  # type: ignore[misc]


def test_file_is_missing(tmp_path: Path) -> None:
    with pytest.raises(RigError, match=r"absent\.toml: no such file; give a rig file, such as"):
        load_rig(tmp_path / "absent.toml")


def test_file_is_a_folder(tmp_path: Path) -> None:
    with pytest.raises(RigError, match="cannot be read"):
        load_rig(tmp_path)


@pytest.mark.parametrize("content", [b"[blade\nheight = 3", b"name = 150 mm"])
def test_file_is_not_toml(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "bad.toml").write_bytes(content)
    with pytest.raises(RigError, match=r"bad\.toml: not valid TOML: .+"):
        load_rig(tmp_path / "bad.toml")


def test_override_below_a_value() -> None:
    with pytest.raises(RigError, match="length is not a table, so unit cannot be set in it"):
        load(wire__length__unit="mm")


PRESSURE = [
    ({}, 'contact.pressure.model: missing; add it, such as model = "uniform"'),
    (
        {"model": "hertz"},
        'contact.pressure.model = "hertz": unknown; allowed are "uniform", "two_area", "polynomial", "by_face", "fe"',
    ),
    (
        {"model": "two_area", "central_share": 1.1, "central_fraction": 0.5},
        "contact.pressure.central_share = 1.1: should be less than or equal to 1, such as 0.8",
    ),
    (
        {"model": "two_area", "central_share": 0.8},
        "contact.pressure.central_fraction: missing; add it, such as central_fraction = 0.5",
    ),
    (
        {"model": "two_area", "central_share": 0.8, "central_fraction": 0},
        "contact.pressure.central_fraction = 0: should be greater than 0",
    ),
    ({"model": "polynomial"}, "contact.pressure.map: state either coefficients or map"),
    (
        {"model": "polynomial", "coefficients": [[1, "x"]]},
        'contact.pressure.coefficients[0][1] = "x": should be a valid number',
    ),
    ({"model": "polynomial", "coefficients": [[1], [0, 0, 0, 0, 1]]}, "at most 4: row i has up to 5 - i entries"),
    ({"model": "polynomial", "coefficients": [1, 2]}, "a list of rows is wanted"),
    (
        {"model": "polynomial", "coefficients": [[-1, 0, 1]]},
        "contact.pressure.coefficients: their mean over the face is -0.666667; it must be above 0",
    ),
    ({"model": "polynomial", "map": "absent.csv"}, "absent.csv cannot be read (No such file or directory)"),
    ({"model": "polynomial", "map": 3}, "contact.pressure.map = 3: the path of a CSV file is wanted"),
    (
        {"model": "by_face", "left": {"model": "uniform"}, "right": {"model": "fe"}},
        'contact.pressure.right.model = "fe": unknown; allowed are "uniform", "two_area", "polynomial"',
    ),
    ({"model": "by_face", "left": {"model": "uniform"}}, "contact.pressure.right: missing"),
    ({"model": "fe", "pull_on": "apex"}, 'contact.pressure.pull_on = "apex"'),
    ({"model": "fe", "friction": "yes"}, 'contact.pressure.friction = "yes": should be a valid boolean'),
    (
        {"model": "fe", "profile": {"crown_height": 2e-6}},
        'contact.pressure.profile.crown_height = 2e-06: state its unit as text, such as "2 um"',
    ),
    (
        {"model": "fe", "profile": {"edge_rounding": "4.1 mm"}},
        "contact.pressure.profile.edge_rounding = 4.1 mm: at most half the face, 4 mm",
    ),
    ({"model": "fe", "profile": {"tilt": "6 deg"}}, "allowed is at least -5 deg and at most 5 deg"),
    ({"model": "fe", "profile": {"crown": "1 m"}}, "contact.pressure.profile.crown = "),
]


@pytest.mark.parametrize(("table", "words"), PRESSURE)
def test_bad_pressure_model(table: dict[str, object], words: str) -> None:
    (line,) = problems(contact__pressure=table)
    assert line.startswith("contact.pressure")
    assert words in line


def test_two_area_pressure() -> None:
    pressure = load(
        contact__pressure={"model": "two_area", "central_share": 1, "central_fraction": 0.4}
    ).contact.pressure
    assert pressure == TwoAreaPressure(model="two_area", central_share=1.0, central_fraction=0.4)


def test_polynomial_coefficients_are_filled_to_a_square() -> None:
    pressure = load(
        contact__pressure={"model": "polynomial", "coefficients": [[1, 0, -0.5], [], [-0.25]]}
    ).contact.pressure
    assert isinstance(pressure, PolynomialPressure)
    assert pressure.coefficients == ((1, 0, -0.5, 0, 0), (0,) * 5, (-0.25, 0, 0, 0, 0), (0,) * 5, (0,) * 5)


def scan(folder: Path, lines: list[str]) -> dict[str, object]:
    (folder / "film.csv").write_text("\n".join(lines))
    return {"model": "polynomial", "map": str(folder / "film.csv")}


def test_scanned_map_is_read_beside_the_rig_file(tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text(REFERENCE.read_text())
    (tmp_path / "film.csv").write_text("s,z,pressure\n" + "".join(f"{i / 8 - 1}, 0.5, {i}\n" for i in range(16)))
    rig = load_rig(tmp_path / "rig.toml", {"contact.pressure": {"model": "polynomial", "map": "film.csv"}})
    assert isinstance(rig.contact.pressure, PolynomialPressure)
    assert rig.contact.pressure.map is not None
    assert rig.contact.pressure.map[3] == (3 / 8 - 1, 0.5, 3.0)
    assert len(rig.contact.pressure.map) == 16


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ([], "must start with the line s,z,pressure, not"),
        (["x,y,p", "0,0,1"], "must start with the line s,z,pressure, not x,y,p"),
        (["s,z,pressure", "0,0,1"], "1 samples; a 4th-order fit needs at least 15"),
        (["s,z,pressure", "0,0"], "sample 1: three numbers are wanted, not 0,0"),
        (["s,z,pressure", "0,0,1", "0,1.5,1"], "sample 2: s and z run from -1 to 1 over the face, not s = 0, z = 1.5"),
        (["s,z,pressure", "0,0,-1"], "sample 1: a pressure is at least 0, not -1"),
        (["s,z,pressure", *["0,0,0"] * 15], "some pressure must be above 0"),
    ],
)
def test_bad_scanned_map(tmp_path: Path, lines: list[str], words: str) -> None:
    (line,) = problems(contact__pressure=scan(tmp_path, lines))
    assert line.startswith("contact.pressure.map")
    assert words in line


def test_surface_profile() -> None:
    profile = {"crown_radius": "2 m", "tilt": "0.01 deg", "edge_rounding": "0.2 mm"}
    pressure = load(contact__pressure={"model": "fe", "friction": False, "profile": profile}).contact.pressure
    assert isinstance(pressure, FePressure)
    assert not pressure.friction
    assert pressure.profile.tilt == pytest.approx(math.radians(0.01))
    assert pressure.profile.crown(8e-3) == pytest.approx((4e-6, 2.0))


def test_crown_that_is_left_out_ends_at_the_ends_of_the_face() -> None:
    assert SurfaceProfile().crown(8e-3) is None
    assert SurfaceProfile(crown_height="4 um").crown(8e-3) == pytest.approx((4e-6, 2.0))  # type: ignore[arg-type]
    both = SurfaceProfile(crown_height="1 um", crown_radius="2 m")  # type: ignore[arg-type]
    assert both.crown(8e-3) == pytest.approx((1e-6, 2.0))


def test_digest_sees_its_own_keys_only() -> None:
    rig, other = load(), load(contact__friction_coefficient=0.7)
    assert rig.digest("mesh.small", "blade", "contact.pressure") == other.digest(
        "mesh.small", "blade", "contact.pressure"
    )
    assert rig.digest("contact") != other.digest("contact")
    assert rig.digest("contact.friction_coefficient") != other.digest("contact.friction_coefficient")
    assert rig.digest("blade", "damper") != rig.digest("blade")


def test_a_list_whose_entries_are_wrong_is_not_told_to_be_too_short() -> None:
    with pytest.raises(RigError) as raised:
        load_rig(REFERENCE, {"study.force_levels": ["0 N"]})
    _, *lines = str(raised.value).splitlines()
    assert lines == ['study.force_levels[0] = "0 N": out of range: allowed is above 0 N and at most 1e+09 N']
