"""Methods that choose all designs beforehand."""

import csv
from io import StringIO

import numpy as np
import pytest
from rich.console import Console
from support.modal_study import STUDY, write_study
from support.study_runs import run

from updamp.design.outputs import best_table, write_outputs
from updamp.design.table import rows

METHODS = {
    'kind = "one_at_a_time"\npoints = 3': 7 - 2,  # the middle of both ranges is the initial design
    'kind = "grid"\npoints = 3': 9,
    'kind = "sobol"\nsamples = 8': 8,
    'kind = "latin_hypercube"\nsamples = 7': 7,
}


@pytest.mark.parametrize("method", METHODS)
def test_as_many_designs_as_were_asked_for_within_their_bounds(folder, method):
    result = run(write_study(folder, method))
    assert len(result.records) == METHODS[method]
    assert [one.number for one in result.records] == sorted({one.number for one in result.records})
    for one in result.records:
        assert 60 <= one.values["frequency"] <= 100
        assert 500 <= one.values["mass"] <= 8000
        assert one.responses["free"] == pytest.approx(one.values["frequency"], rel=1e-9), "its modes are stated"


def test_twice_as_many_points_of_a_sequence_keep_the_first_half(folder):
    first = run(write_study(folder, 'kind = "sobol"\nsamples = 4'))
    second = run(write_study(folder, 'kind = "sobol"\nsamples = 8'))
    assert len(second.records) == 8
    assert second.records[:4] == first.records, "and does not solve it again"


def test_another_set_of_responses_is_another_study_in_the_same_folder(folder):
    run(write_study(folder, 'kind = "grid"\npoints = 2'))
    text = STUDY.replace('name = "free"', 'name = "first"')
    result = run(write_study(folder, 'kind = "grid"\npoints = 2', text=text))
    assert (len(result.records), result.others) == (4, 4)
    assert all(set(one.responses) == {"first"} for one in result.records)


def test_a_design_without_a_response_is_kept_with_its_reason(folder):
    more = '[[responses]]\nname = "second"\nkind = "free_frequency"\nnumber = 2'
    result = run(write_study(folder, 'kind = "grid"\npoints = 2', more))
    for one in result.records:
        assert (one.outcome, one.responses["second"]) == ("partly", None)
        assert "the model keeps 1 modes of beam" in one.reason


@pytest.mark.parametrize(("width", "number"), [(80, 5), (40, 2), (10, 1), (500, 8)])
def test_the_terminal_shows_as_many_designs_as_it_holds_without_cutting_a_number(folder, width, number):
    result = run(write_study(folder, 'kind = "sobol"\nsamples = 8'))
    console = Console(width=max(width, 40), record=True, file=StringIO())
    console.print(best_table(result, width))
    words = console.export_text().split()
    shown = result.records[:number]
    assert [str(one.number) for one in shown] == words[words.index("design") + 1 :][:number]
    for one in shown:
        assert f"{one.values['mass']:.4g}" in words
        assert f"{one.responses['free']:.4g}" in words


def test_the_tables_hold_what_the_records_hold(folder):
    parquet = pytest.importorskip("pyarrow.parquet")
    more = '[[constraints]]\nresponse = "free"\nupper = "0.08 kHz"'
    result = run(write_study(folder, 'kind = "sobol"\nsamples = 8', more))
    write_outputs(result)
    table = parquet.read_table(folder / "out" / "designs.parquet")
    assert table.schema.field("mass").metadata == {b"unit": b"g"}
    content = rows(result.study, result.records)
    assert table.to_pylist() == content
    assert {row["feasible"] for row in content} == {True, False}
    assert all(row["feasible"] == (row["free"] <= 80) for row in content)
    with (folder / "out" / "designs.csv").open() as file:
        lines = list(csv.DictReader(file))
    assert np.allclose([float(line["mass [g]"]) for line in lines], [one.values["mass"] for one in result.records])


SAMPLES = 'kind = "sobol"\nsamples = 4', ""
SEARCH = 'kind = "tpe"\ndesigns = 14', '[[objectives]]\nresponse = "free"\ngoal = "minimise"'


@pytest.mark.parametrize("study", [SAMPLES, pytest.param(SEARCH, marks=pytest.mark.long)])
def test_two_processes_and_a_dask_cluster_find_the_same(folder, study):
    pytest.importorskip("optuna")
    distributed = pytest.importorskip("distributed", reason="Dask is optional: pip install 'updamp[cluster]'")
    path = write_study(folder, *study)
    expected = run(path, jobs=1)
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        by_dask = run(path, out=folder / "dask", scheduler=cluster.scheduler_address)
    by_two = run(path, out=folder / "two", jobs=2)
    for found in (by_dask, by_two):
        assert [one.responses for one in found.records] == [one.responses for one in expected.records]
        assert [(one.number, one.key) for one in found.records] == [(one.number, one.key) for one in expected.records]
