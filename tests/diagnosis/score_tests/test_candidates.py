"""Which effects are looked for in the data, by their score and by how much of them calibration can imitate."""

from types import SimpleNamespace

import numpy as np
import pytest

from updamp.comparison.fit.failing_model import Freedom
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.score_tests.candidates import by_score
from updamp.diagnosis.score_tests.score import Score
from updamp.effects.effect import Effect

CRITERIA = Criteria()


def score(name: str, deviations: float, visibility: float) -> Score:
    """Of an effect that takes so many deviations off, of which calibration can imitate all but a share."""
    effect = Effect(name, f"there is {name}", (), lambda model, _: model)
    return Score(effect, deviations**2, np.ones(1), visibility, 0.0, np.zeros(1))


@pytest.fixture(params=["with contacts", "without"])
def start(request):
    parametrisation = SimpleNamespace(
        base=SimpleNamespace(contacts=object() if request.param == "with contacts" else None),
        nuisances=("E",),
        deviation=np.ones(1),
    )
    compared = SimpleNamespace(mean_squared_misfit=2.4)
    fitted = SimpleNamespace(compared=compared, parametrisation=parametrisation, u=np.zeros(1))
    return SimpleNamespace(fitted=fitted, freedom=Freedom(64.0))


def test_what_calibration_cannot_imitate_of_an_effect_decides_whether_it_is_looked_for(start):
    """Nine tenths of a stiffer wire are a shift of all resonances: beside a contact's viscosity the last one took more
    off than all other effects (case 006 of draw 48571649), and the pair was never fitted."""
    scored = (score("stiffer wire", 40.0, 0.1), score("crack", 18.0, 0.7), score("thinner blade", 1.0, 0.03))
    wanted = [task.effects[0].name for task in by_score(start, scored, CRITERIA)]
    assert wanted == ["stiffer wire", "crack"]
