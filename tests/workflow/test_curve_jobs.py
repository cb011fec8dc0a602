"""Curves are traced, begun again after an interruption, and kept, one by one and many at once."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.broken.folders import KilledJob
from support.plain_rig import curve_jobs

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.workflow import store
from updamp.workflow.curve_jobs import trace_curve
from updamp.workflow.job_pool import JobEnd, run_all

RIG = Path(__file__).parents[1] / "data" / "short_faces.toml"
POINT = "blade_right.tip.x"


@pytest.fixture(scope="module")
def jobs(tmp_path_factory):
    """Two curves of a plain rig near its first stuck mode; the larger force makes the contacts slip."""
    return curve_jobs(RIG, (0.2, 1.0), tmp_path_factory.mktemp("curves"))


@pytest.fixture(scope="module")
def uninterrupted(jobs):
    job = replace(jobs[1], output=jobs[1].output.with_name("uninterrupted.h5"))
    assert trace_curve(job) is JobEnd.FINISHED
    return store.read(job.output, ResponseCurve)


def test_the_whole_branch_is_traced_with_slip(uninterrupted):
    assert uninterrupted.complete
    assert uninterrupted.active.max() > 0
    assert len(uninterrupted) > 20


def test_an_interrupted_curve_is_the_same_to_the_last_digit(jobs, uninterrupted, tmp_path):
    job = replace(jobs[1], output=tmp_path / "curve.h5")
    seen = []
    assert trace_curve(job, seen.append, lambda: len(seen) >= len(uninterrupted) // 2) is JobEnd.INTERRUPTED
    assert list(tmp_path.iterdir()) == [], "half a curve is of no use"
    assert trace_curve(job) is JobEnd.FINISHED
    again = store.read(job.output, ResponseCurve)
    for name in ("frequency", "displacement", "response", "work_in", "friction_loss", "iterations", "error"):
        np.testing.assert_array_equal(getattr(again, name), getattr(uninterrupted, name))


def test_a_curve_that_fails_leaves_the_others(jobs):
    lost = replace(jobs[0], rest=jobs[0].rest.with_name("missing.h5"), output=jobs[0].output.with_name("lost.h5"))
    progress, ended = {}, []
    outcomes = run_all(
        [lost, *jobs], 2, lambda job, p: progress.setdefault(job.name, []).append(p), lambda o: ended.append(o.job)
    )
    by_output = {outcome.job.output: outcome for outcome in outcomes}
    assert by_output[lost.output].end is JobEnd.FAILED
    assert "missing.h5: no such file" in by_output[lost.output].message
    assert len(ended) == 3
    for job in jobs:
        assert by_output[job.output].end is JobEnd.FINISHED
        assert store.read(job.output, ResponseCurve).complete
        assert store.read_stamp(job.output).key == job.key
        shares = [p.share for p in progress[job.name]]
        assert shares == sorted(shares)
        assert 0 <= shares[0] <= shares[-1] <= 1


def test_what_follows_a_job_is_begun_when_that_is_over(jobs, tmp_path):
    first, second = (replace(job, output=tmp_path / job.output.name) for job in jobs)
    begun_with = []

    def following(outcome):
        begun_with.append(outcome.job.output.is_file())
        return [second] if outcome.job == first else []

    outcomes = run_all([first], 2, lambda *_: None, lambda _: None, following)
    assert [outcome.job for outcome in outcomes] == [first, second]
    assert begun_with == [True, True]


def test_what_follows_a_killed_worker_is_lost_with_it(tmp_path):
    first, second = KilledJob(tmp_path / "first"), KilledJob(tmp_path / "second")
    outcomes = run_all([first], 1, lambda *_: None, lambda _: None, lambda o: [second] if o.job == first else [])
    assert [(outcome.job, outcome.end) for outcome in outcomes] == [(first, JobEnd.FAILED), (second, JobEnd.FAILED)]
