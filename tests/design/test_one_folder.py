"""What a folder holds of other studies, other bounds and other processes does not get into this study's results."""

import json

import pytest
from support.modal_study import STUDY, write_study
from support.study_runs import run

from updamp.design.design_rig import write_design_rig
from updamp.design.outputs import write_outputs
from updamp.design.records import alone_in
from updamp.design.table import best_records, problem_of

MOST = '[[objectives]]\nresponse = "free"\ngoal = "maximise"\n'
GRID = 'kind = "grid"\npoints = 3'


def test_designs_beyond_bounds_that_have_been_narrowed_do_not_count(folder):
    run(write_study(folder, GRID, MOST))
    narrow = STUDY.replace('upper = "100 Hz"', 'upper = "80 Hz"')
    result = run(write_study(folder, GRID, MOST, narrow))
    assert {one.values["frequency"] for one in result.records} == {60, 70, 80}
    assert result.others == 3, "those at 100 Hz stay in the folder"
    (best, *_) = best_records(problem_of(result.study), result.records)
    assert best.values["frequency"] == 80


def test_the_rig_of_a_design_of_another_study_is_refused(folder):
    first = run(write_study(folder, GRID))
    old = first.records[0].number
    text = STUDY.replace('lower = "60 Hz"\nupper = "100 Hz"', 'lower = "0.06 kHz"\nupper = "0.1 kHz"')
    second = run(write_study(folder, GRID, text=text))
    write_outputs(second)
    with pytest.raises(ValueError, match=f"design {old} is of another study"):
        write_design_rig(folder / "out", old, folder / "old.toml")
    new = next(one for one in second.records if one.values["frequency"] == 0.1)
    write_design_rig(folder / "out", new.number, folder / "new.toml")
    assert 'frequency = "0.1 kHz"' in (folder / "new.toml").read_text()


def test_two_studies_at_once_in_one_folder_are_refused(folder):
    path = write_study(folder, GRID)
    with alone_in(folder / "out"), pytest.raises(ValueError, match="another study is at work in this folder"):
        run(path)
    assert len(run(path).records) == 9, "the lock goes with the process that holds it"


def test_a_design_that_failed_is_neither_feasible_nor_not_and_its_reason_is_on_the_page(folder):
    more = '[[responses]]\nname = "second"\nkind = "free_frequency"\nnumber = 2\n'
    text = STUDY.replace('name = "free"\nkind = "free_frequency"\n', "").replace("[[responses]]\n", "")
    result = run(write_study(folder, 'kind = "grid"\npoints = 2', more, text))
    write_outputs(result)
    assert {one.outcome for one in result.records} == {"failed"}
    page = (folder / "out" / "study.html").read_text()
    assert "Designs that failed" in page
    assert "number = 2: the model keeps 1 modes of beam" in page
    lines = (folder / "out" / "designs.csv").read_text().splitlines()
    assert [line.split(",")[2] for line in lines[1:]] == [""] * 4
    assert json.loads((folder / "out" / "study.json").read_text())["outcomes"] == {"failed": 4}
