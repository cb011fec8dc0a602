"""The benchmark's measuring functions on tiny problems, and the keys of its file. Nothing here is timed."""

import io
import json
import os
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from updamp.benchmarks.harmonic_balance.growth import Growth, draw
from updamp.benchmarks.harmonic_balance.measure import Cost, branch_cost, counting, in_a_process
from updamp.benchmarks.harmonic_balance.peers_problem import LAWS, THREADS, cost
from updamp.benchmarks.harmonic_balance.results import Results
from updamp.benchmarks.harmonic_balance.rig_curves import AllCurves, CurveCost, stages_of
from updamp.benchmarks.harmonic_balance.synthetic import excitation, synthetic, window
from updamp.hbm.newton.equation import linear_solution
from updamp.hbm.newton.newton import solve


@pytest.fixture(scope="module")
def tiny() -> Cost:
    system = synthetic(6, (0, 1), 32)
    return branch_cost(system, excitation(system), window(system), repeats=3, max_points=8)


def test_branch_is_measured(tiny: Cost) -> None:
    assert tiny.points == 8
    assert tiny.stopped == ""
    assert tiny.unknowns == 6 * 3 * 3
    assert 0 < tiny.evaluation_s < tiny.mean_point_s
    assert tiny.evaluations_mean > tiny.newton_mean >= 1


def test_counts_are_those_of_newton() -> None:
    system = synthetic(6, (0, 1), 32)
    load = excitation(system)
    w = 2 * np.pi * window(system)[0]
    guess = linear_solution(system, w, load)
    with counting() as counts:
        solution = solve(system, load, guess, w)
    assert solution.converged
    assert counts.evaluations >= solution.iterations + 1
    solve(system, load, guess, w)
    assert counts.evaluations <= 2 * (solution.iterations + 1), "counting ends with its block"


def test_synthetic_contacts_are_one_patch_divided() -> None:
    stiffness = [synthetic(n, (0, 1), 32).reference_stiffness.sum() for n in (6, 60)]
    assert stiffness[0] == pytest.approx(stiffness[1], rel=1e-12)


def test_two_threads_are_a_process_of_their_own() -> None:
    assert in_a_process(2, os.getenv, "OMP_NUM_THREADS") == "2"
    assert in_a_process(1, os.getenv, "PJRT_NPROC") == "1"
    assert in_a_process(1, os.getpid) != os.getpid()


def test_missing_problem_is_none() -> None:
    assert cost(LAWS["c_model_146"], "no_such_model.npz") is None


def test_folder_without_stages_is_none(tmp_path: Path) -> None:
    assert stages_of(tmp_path) is None


def test_file_has_the_keys(tiny: Cost, tmp_path: Path) -> None:
    curve = CurveCost("OOP", 9.6, 0.3, 0.3, 0.3, 60, 3, 77, 4.7, 3066, 290, True, "")
    ten = AllCurves(500.0, 2, {"OOP 9.6 N": {"points": 60, "seconds": 18.0, "gaps": 0, "problem": ""}})
    problem = {law: dict.fromkeys(THREADS, tiny) for law in LAWS}
    counts = {"curves": 240, "complete": 239, "checked": 239, "false_peaks": 0}
    stress = {"within_pull": counts, "beyond_pull": counts}
    results = Results(problem, curve, ten, Growth({6: tiny}, {1: tiny}), stress)
    results.write(tmp_path / "bench.json")
    found = json.loads((tmp_path / "bench.json").read_text())
    for law in LAWS:
        for quantity in ("evaluation_s", "point_s"):
            assert found[law][quantity] == dict.fromkeys(THREADS, asdict(tiny)[quantity])
    assert (found["reference_rig"]["point_s"], found["reference_rig"]["ten_curves_s"]) == (0.3, 500.0)
    assert found["stress"] == stress


def test_what_is_missing_is_null_and_said(tiny: Cost, tmp_path: Path) -> None:
    nothing = {law: dict.fromkeys(THREADS) for law in LAWS}
    results = Results(nothing, None, None, Growth({6: tiny, 12: replace(tiny)}, {1: tiny, 2: tiny}), None)
    results.write(tmp_path / "bench.json")
    found = json.loads((tmp_path / "bench.json").read_text())
    assert found["c_model_146"]["point_s"] == {"one_thread": None, "two_threads": None}
    assert found["reference_rig"] == {"point_s": None, "ten_curves_s": None, "ten_curves": None}
    assert found["stress"] == {"within_pull": None, "beyond_pull": None}
    console = Console(record=True, width=200, file=io.StringIO())
    results.show(console)
    said = console.export_text()
    for name in ("c_model_146.npz", "make run", "stress.json", "pyHarm-os"):
        assert name in said
    draw(results.grown, tmp_path / "growth.png")
    assert (tmp_path / "growth.png").stat().st_size > 10_000
