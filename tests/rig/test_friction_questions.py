"""Friction at rest is a box whatever the law: who states the circle with it is told so."""

from pathlib import Path

import pytest

from updamp.model.rig_files import load_rig
from updamp.rig.questions import questions

RIG = Path(__file__).parents[2] / "rigs" / "pesaresi2017.toml"


def asked(law: str, friction: float, pressure: dict[str, object]) -> list[str]:
    changes = {"contact.law": law, "contact.friction_coefficient": friction, "contact.pressure": pressure}
    return questions(load_rig(RIG, changes))


def test_a_circle_with_a_box_at_rest_is_asked_about() -> None:
    (question,) = asked("coulomb_circle", 0.6, {"model": "fe"})
    assert 'contact.law = "coulomb_circle"' in question
    assert 'contact.pressure.model = "fe"' in question
    assert "0.849 N" in question
    assert "where the law allows 0.6" in question
    assert "contact.pressure.friction = false" in question


@pytest.mark.parametrize(
    ("law", "friction", "pressure"),
    [
        ("jenkins_box", 0.6, {"model": "fe"}),
        ("coulomb_circle", 0.0, {"model": "fe"}),
        ("coulomb_circle", 0.6, {"model": "fe", "friction": False}),
        ("coulomb_circle", 0.6, {"model": "uniform"}),
    ],
)
def test_where_both_are_the_same_nothing_is_asked(law: str, friction: float, pressure: dict[str, object]) -> None:
    assert asked(law, friction, pressure) == []
