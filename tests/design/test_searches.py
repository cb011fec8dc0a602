"""Optimisers and sensitivities where the answer is known: the frequency of a rig given by modes is what is stated."""

from importlib.util import find_spec
from types import SimpleNamespace

import numpy as np
import pytest
from support.modal_study import STUDY, write_study
from support.study_runs import run

from updamp.design.methods.sensitivity_samples import analysed
from updamp.design.outputs import write_outputs
from updamp.design.study_file import StudyError, read_study
from updamp.design.table import best_records, problem_of

MINIMISE = '[[objectives]]\nresponse = "free"\ngoal = "{}"\n'
TARGET = '[[objectives]]\nresponse = "free"\ngoal = "target"\ntarget = "0.085 kHz"\ntolerance = "2 Hz"\n'
LIMIT = '[[constraints]]\nresponse = "free"\nlower = "70 Hz"\n'
ONE_VARIABLE = STUDY[: STUDY.index('[[variables]]\nname = "mass"')] + STUDY[STUDY.index("[[responses]]") :]


@pytest.fixture(autouse=True)
def _libraries():
    pytest.importorskip("optuna")
    pytest.importorskip("SALib")


@pytest.mark.parametrize("kind", ["tpe", "nsga2"])
def test_a_search_comes_near_the_limit_and_keeps_it(folder, kind):
    path = write_study(folder, f'kind = "{kind}"\ndesigns = 30', MINIMISE.format("minimise") + LIMIT)
    result = run(path, jobs=1)
    assert 27 <= len(result.records) <= 30, "a genetic algorithm may come back to a design"
    assert result.records[0].values == {"frequency": 80.0, "mass": 2000.0}, "the initial design comes first"
    best = best_records(problem_of(result.study), result.records)
    assert len({one.values["frequency"] for one in best}) == 1, "a child may have it with another mass"
    assert 70 <= best[0].responses["free"] < 74


def test_a_search_goes_on_with_other_designs_where_it_stopped(folder):
    text = 'kind = "tpe"\ndesigns = {}'
    first = run(write_study(folder, text.format(4), MINIMISE.format("maximise")))
    second = run(write_study(folder, text.format(9), MINIMISE.format("maximise")))
    assert second.records[:4] == first.records
    assert len({tuple(one.values.values()) for one in second.records}) == 9, "none is asked for twice"


@pytest.mark.parametrize("kind", ["tpe", "nsga2"])
@pytest.mark.parametrize("sessions", [(5, 6, 11), (8,), (9, 10)])
def test_sessions_come_to_the_designs_of_one_go(folder, kind, sessions):
    """A batch is four: sessions end within one and after one, and in generations of three beside it."""
    more = "\npopulation = 3" if kind == "nsga2" else ""
    goals = MINIMISE.format("minimise") + LIMIT
    for designs in (*sessions, 14):
        result = run(write_study(folder, f'kind = "{kind}"\ndesigns = {designs}{more}', goals))
    whole = run(folder / "study.toml", out=folder / "in_one_go")
    assert [(r.number, r.values) for r in result.records] == [(r.number, r.values) for r in whole.records]


def test_what_was_stored_of_a_batch_when_a_session_was_killed_is_not_stored_twice(folder):
    optuna = pytest.importorskip("optuna")
    text = 'kind = "tpe"\ndesigns = {}'
    goals = MINIMISE.format("minimise")
    run(write_study(folder, text.format(6), goals))
    result = run(write_study(folder, text.format(8), goals))
    storage = f"sqlite:///{folder / 'out' / 'optuna.db'}"
    (name,) = optuna.get_all_study_names(storage)
    trials = optuna.load_study(study_name=name, storage=storage).trials
    assert [one.user_attrs["design"] for one in trials] == list(range(1, 9))
    assert [one.params for one in trials] == [pytest.approx(one.values) for one in result.records]


def test_several_objectives_give_a_front(folder):
    more = MINIMISE.format("minimise") + TARGET
    result = run(write_study(folder, 'kind = "nsga2"\ndesigns = 12\npopulation = 6', more))
    front = best_records(problem_of(result.study), result.records)
    frequencies = [one.responses["free"] for one in front]
    assert frequencies == sorted(frequencies)
    assert sum(f > 85 for f in frequencies) <= 1, "beyond the target both objectives grow"
    assert len(front) > 2


def test_a_gaussian_process_says_what_is_missing_or_finds_the_least(folder):
    path = write_study(folder, 'kind = "gp"\ndesigns = 14', MINIMISE.format("minimise"), ONE_VARIABLE)
    if find_spec("torch") is None:
        with pytest.raises(ValueError, match="torch is not installed; get it with `pip install torch`"):
            run(path)
        return
    result = run(path)
    (best,) = best_records(problem_of(result.study), result.records)
    assert best.responses["free"] == pytest.approx(60, abs=0.5)


@pytest.mark.parametrize("kind", ["tpe", "least_squares"])
def test_an_optimiser_without_an_objective_is_refused(folder, kind):
    with pytest.raises(StudyError, match=r"add \[\[objectives\]\]"):
        read_study(write_study(folder, f'kind = "{kind}"'))


def test_least_squares_want_targets(folder):
    with pytest.raises(StudyError, match='the objective "free" is to be minimised; give all of them goal = "target"'):
        read_study(write_study(folder, 'kind = "least_squares"', MINIMISE.format("minimise")))


def test_least_squares_meet_a_target_and_say_how_well_it_is_determined(folder):
    result = run(write_study(folder, 'kind = "least_squares"', TARGET, ONE_VARIABLE))
    fitted = result.method.summary["fitted"]["frequency"]
    assert fitted["value"] == pytest.approx(85, abs=0.01)
    assert fitted["deviation"] == pytest.approx(2, rel=0.01), "the tolerance of what it is read off"
    write_outputs(result)


def test_the_fit_to_targets_that_contradict_each_other_leads_the_best_designs(folder):
    twin = '[[responses]]\nname = "twin"\nkind = "free_frequency"\n'
    other = '[[objectives]]\nresponse = "twin"\ngoal = "target"\ntarget = "70 Hz"\ntolerance = "1 Hz"\n'
    result = run(write_study(folder, 'kind = "least_squares"', twin + TARGET + other, ONE_VARIABLE))
    (best, *_) = best_records(problem_of(result.study), result.records)
    assert best.number == result.method.summary["design"]
    assert best.responses["free"] == pytest.approx((85 / 4 + 70) / (1 / 4 + 1), abs=0.01)


def test_what_targets_do_not_determine_is_said(folder):
    result = run(write_study(folder, 'kind = "least_squares"', TARGET))
    assert result.method.summary["fitted"]["mass"]["deviation"] is None
    assert any("do not determine" in note for note in result.method.notes)


def test_variance_comes_from_the_variable_that_acts(folder):
    result = run(write_study(folder, 'kind = "sobol_indices"\nsamples = 64'))
    found = {(one.variable, one.measure): one for one in result.method.sensitivities}
    assert len(result.records) == len({tuple(r.values.values()) for r in result.records})
    assert found["frequency", "ST"].value == pytest.approx(1, abs=0.1)
    assert found["mass", "ST"].value == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(("half_widths", "told"), [((0.5, 0.1), True), ((0.3, 0.2), False), ((0.0, 0.0), False)])
def test_shares_that_too_few_samples_do_not_tell_from_none_are_named(half_widths, told):
    names = [SimpleNamespace(name="angle"), SimpleNamespace(name="mass")]
    problem = SimpleNamespace(responses=("peak",), variables=names)
    records = [SimpleNamespace(responses={"peak": float(value)}) for value in range(4)]
    found = analysed(problem, np.zeros((4, 2)), records, 1, lambda *_: {"ST": (np.array([0.4, 0.1]), half_widths)})
    said = ("peak: ST = 0.4 ± 0.5 of angle, the largest, may as well be 0; more samples are needed",)
    assert found.notes == (said if told else ())


def test_elementary_effects_are_the_change_from_bound_to_bound(folder):
    result = run(write_study(folder, 'kind = "morris"\ntrajectories = 4'))
    found = {(one.variable, one.measure): one.value for one in result.method.sensitivities}
    assert found["frequency", "mu_star"] == pytest.approx(40), "Hz"
    assert found["frequency", "sigma"] == pytest.approx(0, abs=1e-6)
    assert found["mass", "mu_star"] == pytest.approx(0, abs=1e-9)


def test_blocks_that_are_not_known_are_left_out_and_counted(folder):
    more = '[[responses]]\nname = "second"\nkind = "free_frequency"\nnumber = 2'
    result = run(write_study(folder, 'kind = "morris"\ntrajectories = 4', more))
    assert {one.response for one in result.method.sensitivities} == {"free"}
    assert "second: 4 of 4 blocks of designs are left out: not all known" in result.method.notes
