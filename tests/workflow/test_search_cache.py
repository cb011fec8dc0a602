"""What a search has found is used again by the same code on the same inputs, and by no other."""

import pickle
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from updamp.diagnosis.criteria import Criteria
from updamp.workflow.kept_results import ResultKey, inputs_digest, read_result, write_result
from updamp.workflow.search_cache import CachedFits, SearchCache

KEY = ResultKey("this code", "these inputs")
OTHER_CODE, OTHER_INPUTS = replace(KEY, code="other code"), replace(KEY, inputs="other inputs")


class Trap:
    """Its pickle must not be opened."""

    def __reduce__(self) -> tuple[object, ...]:
        return _opened, ()


def _opened() -> None:
    raise AssertionError("a pickle of another version was opened")


def test_what_was_kept_is_read_back(tmp_path: Path) -> None:
    said: list[str] = []
    cache = SearchCache(tmp_path / "search", KEY, said.append).without_stale()
    assert cache.read("friction, wire stiffness, until settled") is None
    cache.write("friction, wire stiffness, until settled", {"a": 1})
    assert cache.without_stale().read("friction, wire stiffness, until settled") == {"a": 1}
    assert not said
    assert [path.name for path in (tmp_path / "search").iterdir()] == ["friction__wire_stiffness__until_settled.pickle"]


def test_a_search_of_another_version_is_begun_anew(tmp_path: Path) -> None:
    said: list[str] = []
    for name in ("baseline", "friction"):
        SearchCache(tmp_path, OTHER_CODE, said.append).write(name, Trap())
    assert SearchCache(tmp_path, KEY, said.append).read("baseline") is None, "even where it was not looked for before"
    said.clear()
    cache = SearchCache(tmp_path, KEY, said.append).without_stale()
    assert said == [f"the search kept in {tmp_path} was made by another version of updamp: begun anew"]
    assert cache.read("baseline") is None
    assert list(tmp_path.iterdir()) == []


def test_what_was_kept_before_there_were_keys_is_of_another_version(tmp_path: Path) -> None:
    said: list[str] = []
    (tmp_path / "baseline.pickle").write_bytes(pickle.dumps(("digest", Trap())))
    (tmp_path / "empty.pickle").write_bytes(b"")
    (tmp_path / "list.pickle").write_bytes(b"[1, 2]\n")
    SearchCache(tmp_path, KEY, said.append).without_stale()
    assert len(said) == 1
    assert list(tmp_path.iterdir()) == []


def test_a_search_with_other_inputs_is_left_until_it_is_written_over(tmp_path: Path) -> None:
    said: list[str] = []
    before = SearchCache(tmp_path, OTHER_INPUTS, said.append)
    before.write("baseline", 1)
    before.write("friction", 2)
    cache = SearchCache(tmp_path, KEY, said.append).without_stale()
    assert said == [f"the search kept in {tmp_path} is of another rig file, measurement or other options: begun anew"]
    assert cache.read("baseline") is None
    cache.write("baseline", 3)
    assert (cache.read("baseline"), before.read("baseline"), before.read("friction")) == (3, None, 2)


@pytest.mark.parametrize("damage", [lambda content: content[:-3], lambda content: content[:-3] + b"???"])
def test_a_damaged_file_is_made_anew(tmp_path: Path, damage: object) -> None:
    said: list[str] = []
    cache = SearchCache(tmp_path, KEY, said.append)
    cache.write("baseline", list(range(100)))
    path = tmp_path / "baseline.pickle"
    path.write_bytes(damage(path.read_bytes()))
    assert cache.without_stale().read("baseline") is None
    assert said == [f"{path}: damaged; made anew"]


def test_a_result_alone_says_why_it_is_not_used(tmp_path: Path) -> None:
    said: list[str] = []
    path = tmp_path / "below" / "calibration.pkl"
    assert read_result(path, KEY, said.append) is None
    write_result(path, OTHER_CODE, Trap())
    assert read_result(path, KEY, said.append) is None
    write_result(path, OTHER_INPUTS, Trap())
    assert read_result(path, KEY, said.append) is None
    assert said == [
        f"{path}: kept by another version of updamp; made anew",
        f"{path}: kept for other inputs; made anew",
    ]
    write_result(path, KEY, Trap())
    assert read_result(path, KEY, said.append) is None
    assert said[-1] == f"{path}: cannot be read (AssertionError: a pickle of another version was opened); made anew"
    write_result(path, KEY, 5)
    assert read_result(path, KEY, said.append) == 5


def test_inputs_are_told_apart() -> None:
    assert len({inputs_digest(*parts) for parts in (("a", "b"), ("a b",), ("a\nb",), ("b", "a"))}) == 4
    assert inputs_digest("a", "b") == inputs_digest("a", "b")


def test_an_effect_beside_another_is_not_taken_for_both_at_once(tmp_path: Path) -> None:
    """They are the same model, but the first is named, and credited, as one effect more."""
    made: list[str] = []

    def runner(start: Any, _: Criteria, tasks: Any, done: Any) -> list[None]:
        there = "+".join(e.name for e in start.fitted.parametrisation.effects)
        for task in tasks:
            made.append(f"{there}: {task.name}")
            done(task, None)
        return [None for _ in tasks]

    fits = CachedFits(SearchCache(tmp_path, KEY, lambda _: None), runner)
    crack, preload = SimpleNamespace(name="crack"), SimpleNamespace(name="preload")
    for _ in range(2):
        for there, name in (((), "crack, preload"), ((crack,), "preload"), ((crack, preload), "gap"), ((), "gap")):
            fitted = SimpleNamespace(parametrisation=SimpleNamespace(effects=there))
            start: Any = SimpleNamespace(attempt=0, fitted=fitted)
            task: Any = SimpleNamespace(name=name)
            assert fits(start, Criteria(), [task], lambda *_: None) == [None]
    assert made == [": crack, preload", "crack: preload", "crack+preload: gap", ": gap"]


def test_what_is_kept_of_many_effects_has_a_name_that_a_file_can_have(tmp_path: Path) -> None:
    many = [f"intervals of {' or '.join(f'joint_{i} and joint_{j}' for i in range(9) for j in range(i))}"]
    many.append(f"{many[0]} with ü")
    cache = SearchCache(tmp_path, KEY, print)
    for value, name in enumerate(many):
        cache.write(name, value)
    assert [cache.read(name) for name in many] == [0, 1]
