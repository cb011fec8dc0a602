"""Effects of the user's own that cannot be used are told before anything is computed, with the file and the line."""

from pathlib import Path

import pytest
from support.small_model import parametrisation

from updamp.effects.chosen import ChosenEffect, with_tried_effects
from updamp.effects.effect import Effect
from updamp.effects.own_effects import own_effect, own_effects
from updamp.effects.rig_model import RigModel
from updamp.effects.user_effect import EffectError, OwnCodeError

LAW = """
from dataclasses import dataclass, replace
from typing import NamedTuple

import jax.numpy as jnp

from updamp.api import Effect, EffectParameter
from updamp.effects.rig_model import PointElement


class Size(NamedTuple):
    size: object


@dataclass(frozen=True)
class Law:
    parameters = Size
    directions = 1
    rate_dependent = False

    def force(self, displacement, velocity, parameters):
        {force}

    def reference_stiffness(self, parameters):
        return jnp.zeros(1)


def apply(model, values):
    law = PointElement("own", (model.excitation,), Law(), Size(jnp.full(1, values["size"])))
    {last}


EFFECT = Effect("{name}", "something of mine", (EffectParameter("size", 0.0, 0.0, 9.0, 1.0, "", "a guess"),), apply)
"""
GOOD = "return parameters.size * displacement**3"
LAST = "return replace(model, elements=(*model.elements, law))"


@pytest.fixture(scope="module")
def model() -> RigModel:
    return parametrisation().base


def file(folder: Path, force: str = GOOD, last: str = LAST, name: str = "mine") -> Path:
    path = folder / f"{name}.py"
    path.write_text(LAW.format(force=force, last=last, name=name), encoding="utf-8")
    return path


def line_of(path: Path, text: str) -> int:
    return 1 + next(i for i, line in enumerate(path.read_text(encoding="utf-8").splitlines()) if text in line)


def test_a_usable_one_is_taken(tmp_path: Path, model: RigModel) -> None:
    (effect,) = own_effects([file(tmp_path)], model)
    assert len(effect.apply(model, effect.at_typical()).elements) == len(model.elements) + 1


def test_a_name_of_the_catalogue_is_refused(tmp_path: Path) -> None:
    """Fits are kept by name: one of the two was taken for the other, and the diagnosis ended in a KeyError."""
    with pytest.raises(
        EffectError, match=r'edge_gap\.py: "edge_gap" is the name of an effect of the catalogue; give yours'
    ):
        own_effect(file(tmp_path, name="edge_gap"))


def test_a_unit_that_there_is_not_is_refused(tmp_path: Path) -> None:
    path = file(tmp_path)
    path.write_text(
        path.read_text(encoding="utf-8").replace('1.0, "", "a guess"', '1.0, "blorp", "a guess"'), encoding="utf-8"
    )
    with pytest.raises(EffectError, match='parameter "size" of "mine": unit = "blorp": no such unit'):
        own_effect(path)


def test_two_of_one_name_are_refused(tmp_path: Path, model: RigModel) -> None:
    other = tmp_path / "other"
    other.mkdir()
    with pytest.raises(EffectError, match=r'other/mine\.py: "mine" is the name of the effect of .*mine.py too'):
        own_effects([file(tmp_path), file(other)], model)


@pytest.mark.parametrize(
    ("changed", "place", "said"),
    [
        ({"last": "return model.nothing"}, "model.nothing", "apply of the effect .* AttributeError: .*nothing"),
        ({"last": "pass"}, "", "returns NoneType: end it with return"),
        ({"force": "return parameters.depth * displacement"}, "depth", "force of Law.* AttributeError: .*depth"),
        ({"force": "return displacement[:, 0]"}, "", "adds cannot be used: OwnLawError: Law: force returns shape"),
        ({"force": "return velocity"}, "", "adds cannot be used: OwnLawError: Law: rate_dependent is False"),
        ({"force": "return jnp.sqrt(-1 - displacement**2)"}, "", "force of Law.*is not finite at a motion of 0 m"),
        ({"force": "return displacement * jnp.sqrt(displacement**2)"}, "", "derivative of the force of Law.* of 0 m"),
    ],
)
def test_own_code_that_fails_is_told_with_its_place(tmp_path, model, changed, place, said) -> None:
    path = file(tmp_path, **changed)
    where = f"mine.py, line {line_of(path, place)}: " if place else "mine.py: "
    with pytest.raises(OwnCodeError, match=f"{where}.*{said}") as told:
        own_effects([path], model)
    assert '"mine"' in str(told.value)
    assert "\n" not in str(told.value)
    with pytest.raises(OwnCodeError, match=said):
        with_tried_effects(model, [ChosenEffect(own_effect(path), {"size": 1.0}, file=path)])


def test_a_law_that_can_be_changed_is_refused(tmp_path: Path, model: RigModel) -> None:
    """Compiled functions are kept by law."""
    path = file(tmp_path)
    path.write_text(path.read_text(encoding="utf-8").replace("dataclass(frozen=True)", "dataclass"), encoding="utf-8")
    with pytest.raises(OwnCodeError, match='what the effect "mine" adds cannot be used: TypeError: Law has no hash'):
        own_effects([path], model)


def test_an_effect_without_a_place_is_no_failure(tmp_path: Path, model: RigModel) -> None:
    (effect,) = own_effects([file(tmp_path, last='raise ValueError("no place")')], model)
    assert isinstance(effect, Effect)


def test_the_example_of_the_page_is_usable(tmp_path: Path, model: RigModel) -> None:
    """The stop of docs/effects.md, at another point: this model has no tips."""
    page = (Path(__file__).parents[2] / "docs" / "effects.md").read_text(encoding="utf-8")
    (code,) = [part.split("```")[0] for part in page.split("```python\n") if "class Stop" in part]
    path = tmp_path / "soft_stop.py"
    path.write_text(code.replace("blade_right.tip.x", model.excitation), encoding="utf-8")
    (effect,) = own_effects([path], model)
    element = effect.apply(model, effect.at_typical()).elements[-1]
    assert (element.name, element.points) == ("stop", (model.excitation,))
