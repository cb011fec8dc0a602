"""A few periods from a curve's peak, as a job of a run, and what is said of them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.plain_rig import curve_jobs

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.time_marching.marched_peak import MarchedPeak, Verdict
from updamp.workflow import store
from updamp.workflow.curve_jobs import trace_curve
from updamp.workflow.job_pool import JobEnd
from updamp.workflow.marching_jobs import MarchingJob
from updamp.workflow.marching_summary import moving_peaks
from updamp.workflow.summary import curve_entry
from updamp.workflow.summary_tables import curves_table

RIG = Path(__file__).parents[1] / "data" / "short_faces.toml"
TIP = "blade_right.tip.x"


@pytest.fixture(scope="module")
def job(tmp_path_factory):
    """Of a curve with contacts that slip."""
    folder = tmp_path_factory.mktemp("curves")
    (curve,) = curve_jobs(RIG, (2.0,), folder)
    assert trace_curve(curve) is JobEnd.FINISHED
    return MarchingJob(curve, TIP, "key", folder / "marched.h5")


@pytest.fixture(scope="module")
def finished(job):
    shares = []
    assert job.run(lambda reached: shares.append(reached.share), lambda: False, None) is JobEnd.FINISHED
    assert shares == sorted(shares)
    return store.read(job.curve.output, ResponseCurve), store.read(job.output, MarchedPeak)


def test_the_peak_is_marched_and_kept(job, finished):
    curve, found = finished
    peak = np.abs(curve.amplitude(TIP)).argmax()
    assert curve.active[peak] > 0, "it slips"
    assert found.periods == 20
    assert found.frequency == curve.frequency[peak]
    assert found.amplitude[0] == curve.amplitude(TIP)[peak]
    assert found.verdict == Verdict.STAYS
    assert 0 < found.moved < 0.01
    assert store.read_stamp(job.output).key == "key"
    assert job.conclusion()[1].startswith("stays: ")


def test_an_interrupted_march_leaves_nothing(job, tmp_path):
    again, asked = replace(job, output=tmp_path / "marched.h5"), []

    def after_three():
        asked.append(None)
        return len(asked) > 3

    assert again.run(lambda _: None, after_three, None) is JobEnd.INTERRUPTED
    assert list(tmp_path.iterdir()) == []


def test_the_summary_says_it(finished):
    curve, found = finished
    entry = curve_entry(curve, TIP, marched=found)
    assert entry["marching"]["verdict"] == "stays"
    assert entry["marching"]["moved_percent"] == pytest.approx(100 * found.moved)
    assert moving_peaks([entry]) == []
    assert curve_entry(curve, TIP)["marching"] is None


@pytest.mark.parametrize(
    ("verdict", "said"),
    [(Verdict.MOVES, "moves: 30 %"), (Verdict.LEAVES, "leaves, growing by 40 1/s: 30 %")],
)
def test_a_peak_that_does_not_stay_is_said_below_and_in_the_table(finished, verdict, said):
    curve, found = finished
    entry = curve_entry(curve, TIP, marched=replace(found, verdict=int(verdict), moved=0.3, growth=40.0))
    (sentence,) = moving_peaks([entry])
    assert said in sentence
    assert f"OOP 2 N: the peak at {entry['peak_frequency_Hz']:.2f} Hz" in sentence
    cells = [str(cell) for column in curves_table([entry]).columns for cell in column.cells]
    assert any(verdict.name.lower() in cell for cell in cells)


@pytest.mark.parametrize(("orders", "said"), [([1, 3], True), ([0, 1, 3], False)])
def test_a_mean_position_that_is_held_may_be_why_a_peak_moves(finished, orders, said):
    curve, found = finished
    moving = replace(found, verdict=int(Verdict.MOVES), moved=0.3)
    (sentence,) = moving_peaks([{**curve_entry(curve, TIP, marched=moving), "harmonics": orders}])
    assert sentence.endswith("; harmonic 0, the mean position, is not among those it keeps") == said


def test_a_peak_that_was_not_checked_is_said_with_the_reason(finished):
    curve, found = finished
    unchecked = replace(
        found, verdict=int(Verdict.NOT_CHECKED), moved=np.nan, reach=np.nan, growth=np.nan, reason="the law is new"
    )
    entry = curve_entry(curve, TIP, marched=unchecked)
    assert entry["marching"]["moved_percent"] is entry["marching"]["growth_per_s"] is None
    (sentence,) = moving_peaks([entry])
    assert sentence.endswith("not checked: the law is new")
