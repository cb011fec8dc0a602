"""The picture of the rooms is that of the code, and no arrow rises."""

import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
OUTSIDE = ("tests", "benchmarks", "examples", "tools")  # they import what they like, and nothing imports them


@pytest.fixture(scope="module")
def rooms() -> ModuleType:
    spec = importlib.util.spec_from_file_location("draw_rooms", ROOT / "tools" / "draw_rooms.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["draw_rooms"] = module  # dataclasses ask for it
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def imports(rooms: ModuleType) -> dict[str, set[str]]:
    return rooms.imports()


def without_counts(page: str) -> str:
    return re.sub(r"\| \d+ \| \d+ \|", "| | |", page)


def test_the_page_has_the_rooms_and_arrows_of_the_code(rooms: ModuleType) -> None:
    stored = rooms.PAGE.read_text(encoding="utf-8")
    assert without_counts(stored) == without_counts(rooms.page()), "run tools/draw_rooms.py again"


def test_no_arrow_rises(rooms: ModuleType, imports: dict[str, set[str]]) -> None:
    layers = [rooms.DOORS, *rooms.layers()]
    height = {room: -i for i, layer in enumerate(layers) for room in layer}
    assert {name.split(".")[0] for name in rooms.packages()} == set(height) - set(rooms.DOORS)
    between = rooms.arrows(imports, height)
    assert [(a, b) for a in between for b in between[a] if height[b] >= height[a]] == []
    assert between["workflow"] >= {"report", "model"}, "there are arrows at all"


def test_nothing_that_is_installed_imports_what_is_not(imports: dict[str, set[str]]) -> None:
    installed = {name: of for name, of in imports.items() if name.split(".")[0] not in OUTSIDE}
    assert len(installed) > 300
    assert [name for name, of in installed.items() for other in of if other.split(".")[0] in OUTSIDE] == []


def test_arrows_that_follow_are_left_out_of_the_picture(rooms: ModuleType) -> None:
    between = {"a": {"b", "c", "d"}, "b": {"c"}, "c": {"d"}, "d": set()}
    assert rooms.reduced(between) == {"a": {"b"}, "b": {"c"}, "c": {"d"}, "d": set()}


def test_a_module_belongs_to_the_innermost_room(rooms: ModuleType) -> None:
    of = {"hbm.contact.law": {"rig.rig"}, "hbm.harmonics": {"hbm.contact.law"}, "hbmish.one": {"rig.rig"}}
    assert rooms.arrows(of, ("hbm", "hbm.contact", "rig")) == {
        "hbm": {"hbm.contact"}, "hbm.contact": {"rig"}, "rig": set()
    }  # fmt: skip
