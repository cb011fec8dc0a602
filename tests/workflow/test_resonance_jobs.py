"""A resonance followed in the force as a job of a run: stored, stated, interrupted."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.plain_rig import around_first_stuck_mode, plain_reduced_model

from updamp.fem.finite_element_model import FiniteElementResult
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.resonance.resonance_curve import ResonanceCurve
from updamp.model.rig_files import load_rig
from updamp.workflow import stages, store
from updamp.workflow.curve_jobs import CurveJob, trace_curve
from updamp.workflow.job_pool import JobEnd
from updamp.workflow.resonance_jobs import ResonanceJob
from updamp.workflow.summary import resonance_entry

RIG = Path(__file__).parents[2] / "rigs" / "pesaresi2017.toml"
POINT = "blade_right.tip.x"
LEVELS = ["0.1 N", "0.5 N"]


@pytest.fixture(scope="module")
def job(tmp_path_factory):
    folder = tmp_path_factory.mktemp("resonance")
    window = around_first_stuck_mode(RIG, 2.0)
    rig = load_rig(RIG, {"study.modes.OOP.window": window, "study.force_levels": LEVELS})
    reduced = plain_reduced_model(rig, build_mesh(rig, "small").contacts)
    nothing = np.zeros(0)
    store.write(folder / "fe.h5", FiniteElementResult(reduced, nothing, nothing), store.Stamp("fe"))
    store.write(folder / "rest.h5", static_contact(reduced, rig), store.Stamp("rest"))
    return ResonanceJob(rig, "OOP", POINT, "key", folder / "fe.h5", folder / "rest.h5", folder / "resonance.h5")


@pytest.fixture(scope="module")
def followed(job):
    assert job.run(lambda _: None, lambda: False, None) is JobEnd.FINISHED
    return store.read(job.output, ResonanceCurve)


def test_what_is_stored_reaches_all_levels(job, followed):
    assert followed.complete
    assert job.conclusion()[0]
    assert followed.force[-1] == pytest.approx(0.5)
    assert followed.displacement.shape[0] == len(followed)


def test_it_meets_the_peak_of_the_response_curve(job, followed, tmp_path):
    curve_job = CurveJob(job.rig, "OOP", 0.5, "key", job.finite_elements, job.rest, tmp_path / "curve.h5")
    assert trace_curve(curve_job) is JobEnd.FINISHED
    frequency, receptance = store.read(curve_job.output, ResponseCurve).peak(POINT)
    assert abs(followed.receptance[-1]) == pytest.approx(receptance, rel=1e-4)
    assert followed.frequency[-1] == pytest.approx(frequency, rel=1e-5)


def test_the_summary_has_each_level_once(followed):
    entry = resonance_entry(followed, (0.1, 0.5))
    assert entry["at_levels"]["force_N"] == pytest.approx([0.1, 0.5])
    assert entry["at_levels"]["receptance_mm_per_N"][-1] == pytest.approx(1e3 * abs(followed.receptance[-1]))
    assert entry["complete"]


def test_an_interruption_leaves_no_file(job, tmp_path):
    stopped = replace(job, output=tmp_path / "none.h5")
    assert stopped.run(lambda _: None, lambda: True, None) is JobEnd.INTERRUPTED
    assert not stopped.output.exists()


def test_another_level_is_another_key():
    choice = {"preset": "small", "mode": "OOP", "force": "0"}
    other = load_rig(RIG, {"study.force_levels": ["0.1 N", "0.6 N"], "study.modes.OOP.window": ["432 Hz", "450 Hz"]})
    same = load_rig(RIG, {"study.force_levels": ["0.1 N", "0.5 N"], "study.modes.OOP.window": ["432 Hz", "450 Hz"]})
    assert stages.RESONANCE.key(other, choice) != stages.RESONANCE.key(same, choice)
    assert stages.CURVE.key(other, choice) == stages.CURVE.key(same, choice)
