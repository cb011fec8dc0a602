"""Curves whose harmonics are chosen: as many as their peak needs, resumable between the sets."""

from pathlib import Path

import numpy as np
import pytest
from support.plain_rig import around_first_stuck_mode, plain_reduced_model

from updamp.fem.finite_element_model import FiniteElementResult
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.model.rig_files import load_rig
from updamp.workflow import store
from updamp.workflow.adaptive_curves import AdaptiveCurveJob, ChosenHarmonics, chosen_file
from updamp.workflow.curve_jobs import curve_problem
from updamp.workflow.job_pool import JobEnd
from updamp.workflow.store import Stamp

RIG = Path(__file__).parents[2] / "rigs" / "pesaresi2017.toml"
POINT = "blade_right.tip.x"


@pytest.fixture(scope="module")
def job(tmp_path_factory):
    """Near the first stuck mode of a plain rig, at a force that makes contacts slip."""
    folder = tmp_path_factory.mktemp("adaptive")
    changes = {"study.modes.OOP.window": around_first_stuck_mode(RIG, 2.0), "harmonic_balance.harmonics": "auto"}
    rig = load_rig(RIG, changes)
    reduced, nothing = plain_reduced_model(rig, build_mesh(rig, "small").contacts), np.zeros(0)
    store.write(folder / "fe.h5", FiniteElementResult(reduced, nothing, nothing), Stamp("fe"))
    store.write(folder / "rest.h5", static_contact(reduced, rig), Stamp("rest"))
    files = (folder / "fe.h5", folder / "rest.h5", folder / "curve.h5")
    return AdaptiveCurveJob(rig, "OOP", 1.0, "key", *files, point=POINT, tolerance=0.02)


def test_harmonics_are_added_until_the_peak_stands_and_an_interruption_loses_no_set(job):
    first = job.with_harmonics((0, 1, 2, 3))

    def after_the_first_set() -> bool:
        return first.output.exists()

    assert job.run(lambda _: None, after_the_first_set, None) is JobEnd.INTERRUPTED
    assert not job.output.exists()
    written = first.output.stat().st_mtime_ns
    assert job.run(lambda _: None, lambda: False, None) is JobEnd.FINISHED
    assert first.output.stat().st_mtime_ns == written, "what is there is not traced again"
    curve, chosen = store.read(job.output, ResponseCurve), store.read(chosen_file(job.output), ChosenHarmonics)
    assert curve.complete
    assert curve.orders == chosen.orders
    assert chosen.tried[0] == 3
    assert chosen.tried[-1] >= 5
    finest = store.read(job.with_harmonics(tuple(range(chosen.tried[-1] + 1))).output, ResponseCurve)
    assert abs(finest.peak(POINT)[1] / curve.peak(POINT)[1] - 1) <= 0.02
    assert "no more than the tolerance" in chosen.status
    assert job.conclusion() == (True, f"{len(curve)} points, {curve.seconds:.1f} s, harmonics up to {curve.orders[-1]}")


def test_a_job_with_harmonics_of_its_own_is_solved_with_these(job):
    system, _ = curve_problem(job.with_harmonics((0, 1, 2, 3, 4, 5)))
    assert system.harmonics.orders == (0, 1, 2, 3, 4, 5)
    assert system.time_samples == 128
