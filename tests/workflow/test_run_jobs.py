"""Which jobs follow a traced curve."""

from pathlib import Path

import pytest
from support.curves import softening_curve

from updamp.model.rig_files import load_rig
from updamp.workflow.curve_jobs import CurveJob
from updamp.workflow.run_jobs import RunJobs, StageFiles
from updamp.workflow.run_options import RunOptions

RIG = Path(__file__).parents[2] / "rigs" / "pesaresi2017.toml"
STATED, CHOSEN = {}, {"harmonic_balance.harmonics": "auto", "harmonic_balance.tolerance": 0.01}


@pytest.mark.parametrize("overrides", [STATED, CHOSEN], ids=["stated", "chosen"])
@pytest.mark.parametrize("complete", [True, False])
def test_only_a_complete_curve_is_traced_with_more_harmonics(overrides, complete):
    rig = load_rig(RIG, overrides)
    files = StageFiles(rig, RunOptions("small", Path("out"), accuracy=True, stability=True, marching=True))
    jobs = RunJobs(files, "blade_right.tip.x", Path("fe.h5"), Path("rest.h5"))
    begun = [job for job in jobs.at_once() if isinstance(job, CurveJob)]
    assert not any(job.finer for job in begun), "whether a curve is complete is not known yet"
    job = begun[0]
    curve = softening_curve(job.mode, job.force, stopped="" if complete else "widen the window")
    after = jobs.following(job, curve)
    finer = [one for one in after if isinstance(one, CurveJob)]
    assert len(finer) == complete
    assert all(one.finer and one.orders == curve.orders for one in finer)
    assert len(after) == 3 + complete
    assert jobs.count_following(job) == 4
