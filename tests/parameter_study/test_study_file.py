"""Study files: what is read, and what is refused."""

from pathlib import Path

import pytest
from support.parameter_study import STUDY, study_folder

from updamp.design.study_file import StudyError
from updamp.parameter_study.families import CurveName
from updamp.parameter_study.study_file import FINDINGS, read_parameter_study

REFERENCE = Path(__file__).parents[2] / "rigs" / "studies" / "pesaresi2017.toml"


def test_a_study_is_read_with_forces_in_newtons_and_a_folder_a_mesh(tmp_path):
    study = read_parameter_study(study_folder(tmp_path))
    assert study.out == tmp_path / "out" / "tiny"
    assert list(study.families[0].curves())[:3] == [
        CurveName("film", "OOP", 0.096), CurveName("50/50", "OOP", 0.096), CurveName("film", "OOP", 0.96),
    ]  # fmt: skip
    assert study.measured[0].frequency == 435.9


def test_all_modes_and_forces_of_the_rig_where_a_family_states_none(tmp_path):
    text = STUDY.replace('modes = ["OOP"]\nforces = ["0.096 N", "0.96 N"]\n', "")
    (family,) = read_parameter_study(study_folder(tmp_path, text)).families
    assert family.modes == ("OOP", "IP")
    assert family.forces == (0.096, 0.96, 3.84, 9.6, 17.0)


WRONG = [
    ('findings = "pesaresi2017"', 'findings = "other"', 'study.findings = "other": unknown; there are pesaresi2017'),
    ('mesh = "tiny"', 'mesh = "huge"', 'study.mesh = "huge": the rig file has no such preset'),
    ('model = "uniform"', 'model = "hertz"', 'variants[1], "50/50": contact.pressure.model = "hertz": unknown'),
    ('name = "50/50"', 'name = "film"', 'variants: name = "film" is there 2 times; keep one'),
    ('variants = ["film", "50/50"]', 'variants = ["flim"]', 'families[0].variants: "flim" is unknown; there are film'),
    ('modes = ["OOP"]', 'modes = ["XX"]', 'families[0].modes: "XX" is unknown; there are OOP, IP'),
    ('"responses", "against', '"response", "against', 'families[0].pictures: "response" is unknown'),
    ("up = 0.0", "up = 3", "contacts.A2.up = 3: should be less than or equal to 1"),
    ('face = "right", up = 1.0', 'face = "top", up = 1.0', "contacts.A1.face"),
    ('mode = "OOP"\nforce', 'mode = "ip"\nforce', 'measured.mode: "ip" is unknown'),
]


@pytest.mark.parametrize(("right", "wrong", "words"), WRONG)
def test_what_is_wrong_is_named(tmp_path, right, wrong, words):
    assert right in STUDY
    with pytest.raises(StudyError) as refused:
        read_parameter_study(study_folder(tmp_path, STUDY.replace(right, wrong, 1)))
    assert words in str(refused.value)


def test_the_study_of_the_paper_has_the_curves_that_its_findings_ask_for():
    """Each name that a finding uses is a variant, and its modes and forces are among the families'."""
    from updamp.parameter_study.findings import pesaresi_names as names

    study = read_parameter_study(REFERENCE, "small")
    curves = {curve for family in study.families for curve in family.curves()}
    levels = {CurveName(v, m, f) for v in (names.FILM, names.UNIFORM, names.LUMPED) for m in (names.OOP, names.IP)
              for f in names.FORCES}  # fmt: skip
    splits = {CurveName(v, names.OOP, f) for v in (*names.SPLITS, names.ASYMMETRIC) for f in (3.84, 17.0)}
    others = {CurveName(v, names.OOP, 3.84) for v in names.STIFFNESSES}
    others |= {CurveName(v, names.IP, 9.6) for v in (*names.ODD_NAMES, names.WITH_MEAN)}
    assert levels | splits | others <= curves
    assert {*names.CENTRES, *names.EDGES, names.UPPER, names.LOWER} <= {place.name for place in study.contacts}
    assert [one.number for one in FINDINGS["pesaresi2017"]] == list(range(1, 16))
