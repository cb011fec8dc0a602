"""Stage products come back from their files as they went in, and damaged files say so."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass

import h5py
import numpy as np
import pytest

from updamp.fem.reduced_model import ReducedComponent, ReducedModel
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.geometry.contact_elements import ContactElements
from updamp.geometry.rig_mesh import ComponentMesh, RigMesh
from updamp.workflow import store
from updamp.workflow.store import Stamp, StoreError, UnitError
from updamp.workflow.store_units import UNITS

STAMP = Stamp("abc123", {"assembly": 1.5, "modes": 20.25}, ((10.0, 12.5), (20.0, 21.0)), 3e9)


def _random(*shape):
    return np.random.default_rng(len(shape) + sum(shape)).normal(size=shape)


def _contacts(n=4):
    return ContactElements(
        face=np.repeat([0, 1], n // 2),
        point=_random(n, 3),
        area=_random(n) ** 2,
        tangent1=_random(n, 3),
        tangent2=_random(n, 3),
        normal=_random(n, 3),
        triangle=_random(n, 3, 3),
    )


def _mesh():
    hexahedra = np.arange(16).reshape(2, 8)
    component = ComponentMesh("blade", _random(16, 3), hexahedra, {"root": hexahedra[:, :4]}, {"tip": 3, "platform": 7})
    empty = ComponentMesh("damper", np.zeros((0, 3)), np.zeros((0, 8), dtype=np.int64), {}, {})
    return RigMesh(component, empty, _contacts(), 0.75)


def _reduced():
    left, right, damper = (
        ReducedComponent(name, _random(3) ** 2, _random(n, 3), _random(n, n), points)
        for name, n, points in (("blade_left", 7, ("tip.x",)), ("blade_right", 6, ()), ("damper", 14, ("a.x", "a.y")))
    )
    return ReducedModel(left, right, damper, _contacts(), 4e-8)


def _rest():
    return StaticContact("uniform", _random(4) ** 2, _random(4, 2), np.zeros(4), 960.0, 1234.5, 1e-16)


def assert_same(a, b):
    assert type(a) is type(b)
    if is_dataclass(a):
        for entry in fields(a):
            assert_same(getattr(a, entry.name), getattr(b, entry.name))
    elif isinstance(a, Mapping):
        assert list(a) == list(b)
        for key in a:
            assert_same(a[key], b[key])
    elif isinstance(a, tuple):
        assert len(a) == len(b)
        for one, other in zip(a, b, strict=True):
            assert_same(one, other)
    elif isinstance(a, np.ndarray):
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(a, b)
    else:
        assert a == b


@pytest.mark.parametrize("product", [_mesh(), _reduced(), _rest()], ids=lambda p: type(p).__name__)
def test_products_come_back_as_they_were(tmp_path, product):
    store.write(tmp_path / "deep" / "p.h5", product, STAMP)
    assert_same(store.read(tmp_path / "deep" / "p.h5", type(product)), product)
    assert store.read_stamp(tmp_path / "deep" / "p.h5") == STAMP
    assert [p.name for p in (tmp_path / "deep").iterdir()] == ["p.h5"], "no temporary file is left"


@dataclass(frozen=True, eq=False)
class Everything:
    flag: bool
    count: int
    size: float
    name: str
    names: tuple[str, ...]
    numbers: tuple[int, ...]
    window: tuple[float, float]
    nothing: float | None
    none_yet: tuple[str, ...]
    amplitude: np.ndarray
    tables: Mapping[str, np.ndarray]
    parts: tuple[StaticContact, ...]
    by_name: Mapping[str, StaticContact]


@pytest.fixture
def everything(monkeypatch):
    numbers = ("flag", "count", "size", "numbers", "window", "nothing", "amplitude", "tables")
    monkeypatch.setattr(store, "UNITS", {**UNITS, "Everything": dict.fromkeys(numbers, "m")})
    return Everything(
        True, 3, 0.1, "µ and 45°", ("a", "b"), (0, 1, 3), (1.5, 2.5), None, (),
        np.array([1 + 2j, -3j]), {"z.first": np.arange(3), "a": np.zeros(0)}, (_rest(), _rest()), {"one": _rest()},
    )  # fmt: skip


def test_every_kind_of_field_survives(tmp_path, everything):
    store.write(tmp_path / "e.h5", everything, STAMP)
    assert_same(store.read(tmp_path / "e.h5", Everything), everything)


def test_every_number_carries_its_unit_and_the_file_its_origin(tmp_path):
    store.write(tmp_path / "r.h5", _reduced(), STAMP)
    units = {}
    with h5py.File(tmp_path / "r.h5") as file:
        assert file.attrs["schema"] == store.SCHEMA_VERSION
        assert file.attrs["input_hash"] == "abc123"
        assert file.attrs["code_version"].startswith("updamp ")
        assert file.attrs["created"].startswith("20")
        file.visititems(
            lambda name, item: units.update({name: item.attrs.get("unit")}) if isinstance(item, h5py.Dataset) else None
        )
    assert units["product/damper/residual"] == "m/N"
    assert units["product/contacts/area"] == "m^2"
    assert [name for name, unit in units.items() if unit is None] == [
        f"product/{component}/{text}"
        for component in ("blade_left", "blade_right", "damper")
        for text in ("name", "points")
        if (component, text) != ("blade_right", "points")
    ], "only text goes without a unit"


def test_a_field_without_unit_is_refused_by_name(tmp_path, monkeypatch):
    monkeypatch.setattr(store, "UNITS", {"StaticContact": {"normal_force": "N"}})
    with pytest.raises(UnitError, match=r"StaticContact\.tangential_force has no unit"):
        store.write(tmp_path / "s.h5", _rest(), STAMP)
    assert list(tmp_path.iterdir()) == []


def test_a_failed_write_leaves_the_earlier_file(tmp_path, monkeypatch):
    store.write(tmp_path / "s.h5", _rest(), STAMP)
    monkeypatch.setattr(store, "UNITS", {})
    with pytest.raises(UnitError):
        store.write(tmp_path / "s.h5", _rest(), Stamp("other"))
    assert store.read_stamp(tmp_path / "s.h5") == STAMP
    assert [p.name for p in tmp_path.iterdir()] == ["s.h5"]


def _cut_short(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def _flip_a_bit_of_the_data(path):
    content = bytearray(path.read_bytes())
    place = content.index(np.float64(77.25).tobytes())
    content[place] ^= 1
    path.write_bytes(content)


def _other_schema(path):
    with h5py.File(path, "a") as file:
        file.attrs["schema"] = 0


def _other_fields(path):
    with h5py.File(path, "a") as file:
        del file["product/gap"]


@pytest.mark.parametrize(
    ("damage", "reason"),
    [
        (_cut_short, "damaged"),
        (lambda path: path.write_text("not HDF5"), "damaged"),
        (_flip_a_bit_of_the_data, "damaged"),
        (_other_schema, "written with schema 0, this version reads 1"),
        (_other_fields, r"other fields than this version's \(gap\)"),
        (lambda path: path.unlink(), "no such file"),
    ],
)
def test_a_file_that_cannot_be_used_says_so_and_what_to_do(tmp_path, damage, reason):
    path = tmp_path / "rest.h5"
    rest = StaticContact("uniform", np.full(4, 77.25), np.zeros((4, 2)), np.zeros(4), 960.0, 1.0, 0.0)
    store.write(path, rest, STAMP)
    damage(path)
    with pytest.raises(StoreError, match=rf"rest\.h5.*{reason}.*delete the file"):
        store.read(path, StaticContact)


def test_another_product_is_not_taken_for_the_one_wanted(tmp_path):
    store.write(tmp_path / "x.h5", _rest(), STAMP)
    with pytest.raises(StoreError, match="holds a StaticContact where a RigMesh is wanted"):
        store.read(tmp_path / "x.h5", RigMesh)
