"""A study file is read, or refused with what to do: every problem in one message."""

from pathlib import Path

import pytest
from support.modal_study import STUDY, write_study
from support.study_runs import run

from updamp.design.study_file import StudyError, read_study
from updamp.design.variables import overrides

RIG = Path(__file__).parents[2] / "rigs" / "pesaresi2017.toml"
OBJECTIVE = '[[objectives]]\nresponse = "{}"\n{}\n'


def test_values_come_in_the_units_that_the_study_states(folder):
    study = read_study(write_study(folder))
    frequency, mass = study.variables
    assert (frequency.unit, frequency.lower, frequency.upper, frequency.initial) == ("Hz", 60, 100, 80)
    assert (mass.unit, mass.lower, mass.upper, mass.initial) == ("g", 500, 8000, 2000)
    assert mass.at(0.5) == pytest.approx(2000), "half way of a logarithmic range is the geometric mean"
    assert mass.share(mass.at(0.3)) == pytest.approx(0.3)


def test_what_replaces_the_rigs_values_is_written_as_in_its_file(folder):
    study = read_study(write_study(folder))
    changes = overrides({}, study.variables, {"frequency": 90.0, "mass": 1500.0})
    assert changes == {"modes.first.frequency": "90.0 Hz", "modes.first.modal_mass": "1500.0 g"}


def test_an_effect_that_the_rig_has_not_is_added_and_one_that_it_has_keeps_its_other_values(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(
        f'[study]\nrig = "{RIG}"\n'
        '[[variables]]\nname = "gap"\npath = "effects.edge_gap.depth"\nlower = "0.1 um"\nupper = "1 um"\n'
        '[[responses]]\nname = "mass"\nkind = "damper_mass"\n[method]\nkind = "grid"\n'
    )
    study = read_study(path)
    assert study.variables[0].initial == 0.1, "absent as the rig stands, so the nearer bound"
    stated = {"effects": [{"name": "edge_gap", "values": {"depth": "1 um", "other": 3}}]}
    assert overrides({}, study.variables, {"gap": 0.5})["effects"] == [
        {"name": "edge_gap", "values": {"depth": "0.5 um"}}
    ]
    assert overrides(stated, study.variables, {"gap": 0.5})["effects"][0]["values"] == {"depth": "0.5 um", "other": 3}
    assert stated["effects"][0]["values"]["depth"] == "1 um", "what was read is left alone"


def test_an_effect_whose_joint_is_at_another_point_has_that_points_name_in_its_path(folder):
    cubic = "joint_cubic@beam.drive.x"
    text = STUDY.replace("modes.first.frequency", f"effects.{cubic}.coefficient").replace(" Hz", " N/m^3")
    study = read_study(write_study(folder, text=text))
    (table,) = overrides({}, study.variables[:1], {study.variables[0].name: 75.0})["effects"]
    assert (table["name"], list(table["values"])) == (cubic, ["coefficient"])


def test_what_else_is_wrong_is_told_beside_a_mistake_in_the_first_table(folder):
    text = STUDY.replace('out = "out"', 'outt = "out"').replace('kind = "free_frequency"', 'kind = "free"')
    with pytest.raises(StudyError) as refused:
        read_study(write_study(folder, text=text))
    assert "study.outt" in str(refused.value)
    assert 'responses[0].kind = "free"' in str(refused.value)


def test_a_component_that_the_rig_has_not_and_bounds_of_a_whole_number_are_refused(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(
        f'[study]\nrig = "{RIG}"\n[[variables]]\nname = "modes"\npath = "reduction.modes"\nlower = 4.5\nupper = 8\n'
        '[[responses]]\nname = "f"\nkind = "free_frequency"\ncomponent = "blade_lefty"\n[method]\nkind = "grid"\n'
    )
    with pytest.raises(StudyError) as refused:
        read_study(path)
    assert "lower = 4.5: a whole number is wanted" in str(refused.value)
    assert 'component = "blade_lefty": the rig has blade_left, blade_right, damper' in str(refused.value)


def test_a_point_that_the_rig_has_not_is_refused_before_any_design(folder):
    peak = '[[responses]]\nname = "p"\nkind = "peak_receptance"\nmode = "first"\nforce = "1 N"\npoint = "nowhere"\n'
    with pytest.raises(ValueError, match=r'response p: point = "nowhere": the rig has beam\.drive\.x'):
        run(write_study(folder, more=peak))


@pytest.mark.parametrize(
    ("wrong", "right", "message"),
    [
        ("modes.first.freqency", "modes.first.frequency", "did you mean frequency?"),
        ("modes.second.frequency", "modes.first.frequency", "modes.second: the rig file has no such key"),
        ("modes.first.shape", "modes.first.frequency", "is not a number of the rig"),
        ("effects.nothing.size", "modes.first.frequency", "no such effect"),
        ("effects.edge_gap.width", "modes.first.frequency", "no such parameter; "),
        ("calibration.friction", "modes.first.frequency", "calibration.friction: unknown factor"),
        ('"60 mm"', '"60 Hz"', "lower = '60 mm': wrong dimension: needs a unit of the kind Hz"),
        ("60", '"60 Hz"', "lower = 60.0: not a number with a unit"),
        ('"120 Hz"', '"60 Hz"', "the lower bound must be below the upper one"),
        ('"-60 Hz"', '"60 Hz"', "out of range: allowed is above 0"),
        ('name = "frequency"', 'name = "mass"', 'variables: name = "frequency" is there 2 times'),
        ('"free_freqency"', '"free_frequency"', 'responses[0].kind = "free_freqency": unknown; did you mean'),
        ('name = "seconds"', 'name = "free"', 'name = "seconds": is another column of the table already'),
        ('"damper_mass"', '"free_frequency"', "responses[0].kind: a rig given by modes has no geometry"),
        ('"beem.toml"', '"beam.toml"', "no such file"),
    ],
)
def test_what_is_wrong_is_named_with_what_would_be_right(folder, wrong, right, message):
    text = STUDY.replace(right, wrong, 1)
    with pytest.raises(StudyError) as refused:
        read_study(write_study(folder, text=text))
    assert message in str(refused.value)


@pytest.mark.parametrize(
    ("method", "more", "message"),
    [
        ('kind = "sobl"', "", 'method.kind = "sobl": unknown; did you mean sobol?'),
        ('kind = "sobol"\nsamples = 12', "", "a power of 2 is wanted, such as 8 or 16"),
        ('kind = "grid"\nsamples = 12', "", "method.samples = 12: unknown key"),
        ('kind = "grid"', OBJECTIVE.format("free", 'goal = "lower"'), 'goal = "lower": unknown; allowed are minimise'),
        ('kind = "grid"', OBJECTIVE.format("fre", ""), 'response = "fre": the study has no such response; it has free'),
        ('kind = "grid"', OBJECTIVE.format("free", 'goal = "target"'), "target: missing"),
        (
            'kind = "grid"',
            OBJECTIVE.format("free", 'goal = "target"\ntarget = 80\ntolerance = "1 Hz"'),
            "objectives[0].target = 80.0: state its unit",
        ),
        ('kind = "grid"', '[[constraints]]\nresponse = "free"', "constraints[0].lower, upper: both missing"),
        (
            'kind = "grid"',
            '[[constraints]]\nresponse = "free"\nlower = "90 Hz"\nupper = "80 Hz"',
            "the lower limit must be below the upper one",
        ),
    ],
)
def test_goals_and_methods_are_checked(folder, method, more, message):
    with pytest.raises(StudyError) as refused:
        read_study(write_study(folder, method, more))
    assert message in str(refused.value)


def test_all_problems_come_at_once(folder):
    text = STUDY.replace('"60 Hz"', '"60 mm"').replace("free_frequency", "fre")
    with pytest.raises(StudyError) as refused:
        read_study(write_study(folder, 'kind = "gird"', text=text))
    assert len(str(refused.value).splitlines()) == 4, "the file, then a line a problem"
