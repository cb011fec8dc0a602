"""The command line and the run behind it, on the small mesh with two short curves."""

import csv
import io
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import psutil
import pytest
from rich.console import Console
from support.curves import softening_curve
from support.short_study import RIG, run_command, short_study

from updamp.commands import predict
from updamp.fem.lumped_damper import damper_mass
from updamp.hbm.analysis.finer_points import PointErrors
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.stability.branch_stability import BranchStability, State
from updamp.model.rig_files import load_rig
from updamp.parallel.resources import Meter
from updamp.pictures import scene
from updamp.rig.damper_mass import damper_mass as mass_of_dimensions
from updamp.workflow import stages, store
from updamp.workflow.accuracy_summary import error_cells, numerical_error
from updamp.workflow.products import Products, Stored
from updamp.workflow.progress import Display
from updamp.workflow.run import Run
from updamp.workflow.run_options import RunOptions
from updamp.workflow.stage_functions import StageFunctions
from updamp.workflow.summary import union_length

SUMMARY_KEYS = {
    "mesh": {"blade_elements", "damper_elements", "contact_elements", "min_scaled_jacobian"},
    "modes": {"per_component", "free_1F_Hz", "max_relative_residual"},
    "coupled_linear": {"OOP_Hz", "IP_Hz"},
    "static_contact": {"applied_N", "normal_total_N", "equilibrium_error"},
    "timing_s": {"mesh", "assembly", "modes", "reduction", "static_contact", "hbm", "total"},
}
CURVE_KEYS = {
    "mode", "force_N", "peak_receptance_mm_per_N", "peak_frequency_Hz", "points", "unconverged", "seconds",
}  # fmt: skip
PICTURES = ("mesh.png", "modes.png", "mode.gif", "pressure.png", "frf_OOP.png", "frf_IP.png", "damper_motion.png",
            "contact_states_OOP.png", "contact_states_IP.png", "force_loops_OOP.png", "force_loops_IP.png",
            "resonance_OOP.png", "resonance_IP.png")  # fmt: skip

RENDERED = ("mesh.png", "modes.png", "mode.gif")


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A finished run: its rig file, its folder, what it printed."""
    folder = tmp_path_factory.mktemp("run")
    rig = short_study(folder, (441, 459), (431, 447))
    result = run_command("run", rig, "--mesh", "small", "--out", folder / "out", "--jobs", 1, "--no-accuracy")
    assert result.exit_code == 0, result.output
    return rig, folder / "out", result.output


def test_a_run_writes_all_it_promises(finished):
    _, out, _ = finished
    for name in PICTURES:
        assert 1_000 < (out / "pictures" / name).stat().st_size < 300_000, name
    for name in ("blade_left", "blade_right", "damper", "contacts"):
        assert (out / "mesh" / f"{name}.vtu").exists()
    names = {path.name for path in (out / "stages").glob("*.h5")}
    of_curves = {f"{kind}_{mode}_0.01N.h5" for kind in ("curve", "stability", "marched_peak") for mode in ("OOP", "IP")}
    of_modes = {f"resonance_{mode}.h5" for mode in ("OOP", "IP")}
    assert names == {f"{stage.name}.h5" for stage in stages.STAGES[:6]} | of_curves | of_modes


def test_the_summary_has_its_keys_and_sound_numbers(finished):
    summary = json.loads((finished[1] / "summary.json").read_text())
    for section, wanted in SUMMARY_KEYS.items():
        assert wanted <= set(summary[section])
    assert all(set(entry) >= CURVE_KEYS for entry in summary["curves"])
    assert {(entry["mode"], entry["force_N"]) for entry in summary["curves"]} == {("OOP", 0.01), ("IP", 0.01)}
    assert 0.1 < summary["peak_memory_GB"] < 12
    for entry in summary["curves"]:
        coupled = summary["coupled_linear"][f"{entry['mode']}_Hz"]
        assert coupled["reduced"] == pytest.approx(coupled["full"], rel=1e-3)
        assert entry["peak_frequency_Hz"] == pytest.approx(coupled["reduced"], rel=1e-3)
        assert entry["unconverged"] == 0
        assert entry["problem"] == ""
        assert entry["energy_balance_error"] < 0.01
        assert entry["stability"]["peak"] == "stable"
        assert entry["stability"]["points"] == {"stable": entry["points"], "unstable": 0, "unknown": 0}
        assert entry["marching"]["verdict"] == "stays"
        assert entry["marching"]["periods"] == 0, "all contacts stick"
        assert entry["stability"]["unstable_Hz"] == entry["stability"]["unknown_Hz"] == []
    for entry, followed in zip(summary["curves"], summary["resonances"], strict=True):
        assert followed["complete"]
        assert followed["at_levels"]["receptance_mm_per_N"] == pytest.approx(
            [entry["peak_receptance_mm_per_N"]], rel=1e-4
        )
    timing = summary["timing_s"]
    assert timing["total"] > timing["hbm"] > 0
    assert timing["total"] > timing["assembly"] + timing["modes"] + timing["reduction"]


def test_the_numerical_error_is_stated_unless_it_is_left_out(finished, tmp_path):
    """Where all contacts stick more harmonics change nothing. The curves that are there are not traced again."""
    rig, out, _ = finished
    shutil.copytree(out, tmp_path / "out")
    before = (out / "stages" / "curve_OOP_0.01N.h5").read_bytes()
    options = ("--mode", "OOP", "--no-pictures", "--no-check")
    result = run_command("run", rig, "--mesh", "small", "--out", tmp_path / "out", *options)
    assert result.exit_code == 0, result.output
    assert "error: what harmonics" in " ".join(result.output.split())
    (entry,) = json.loads((tmp_path / "out" / "summary.json").read_text())["curves"]
    error = entry["numerical_error"]
    assert error["orders"] == [0, 1, 2, 3, 4, 5, 6, 7]
    assert error["complete"]
    assert abs(error["peak_percent"]) < 1e-3
    assert abs(error["resonance_hertz"]) < 1e-4
    for refined in ("samples", "cycles"):
        assert abs(error[refined]["peak_percent"]) < 1e-6
        assert abs(error[refined]["flank_percent"]) < 1e-6
    assert error["not_known"] == ""
    assert (tmp_path / "out" / "stages" / "curve_OOP_0.01N.h5").read_bytes() == before
    without = json.loads((out / "summary.json").read_text())["curves"]
    assert [entry["numerical_error"] for entry in without] == [None, None]


def test_an_error_that_is_not_known_says_why_and_the_run_goes_on():
    curve = softening_curve(force=1.0)
    stamp, path = store.Stamp("key"), Path("curve.h5")
    finer = replace(curve, complete=False, stopped="the branch stops")
    nothing = (float("nan"),) * 3
    points = PointErrors(curve.mode, 1.0, (0.1, 0.01, 0.2), nothing, "finer points were not solved at 5.00 Hz")
    products = Products(
        Stored(path, None, stamp), finer=(Stored(path, finer, stamp),), point_errors=(Stored(path, points, stamp),)
    )
    error = numerical_error(products, curve, "blade_right.tip.x")
    assert "is not complete (the branch stops)" in error["not_known"]
    assert "finer points were not solved" in error["not_known"]
    assert error["cycles"]["peak_percent"] is None
    assert error["samples"]["peak_percent"] == 0.1
    assert error["peak_percent"] == 0
    none = numerical_error(replace(products, finer=(), point_errors=()), curve, "blade_right.tip.x")
    assert "the curve with more harmonics failed" in none["not_known"]
    assert error_cells(none) == ("not known", "")
    short = replace(curve, complete=False, stopped="widen the window")
    known = numerical_error(replace(products, finer=()), short, "blade_right.tip.x")["not_known"]
    assert known.startswith("not known: the curve is not complete, and was not traced with more harmonics")


def test_the_csv_holds_the_curves(finished):
    _, out, _ = finished
    curve = store.read(out / "stages" / "curve_OOP_0.01N.h5", ResponseCurve)
    with (out / "frf_OOP.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["mode", "force_N", "frequency_Hz", "point", "harmonic", "real_m", "imag_m", "stability"]
    tip = [r for r in rows if r["point"] == "blade_left.tip.x" and r["harmonic"] == "1"]
    written = np.array([complex(float(r["real_m"]), float(r["imag_m"])) for r in tip])
    np.testing.assert_allclose(written, curve.amplitude("blade_left.tip.x"), rtol=1e-7, atol=1e-20)
    np.testing.assert_allclose([float(r["frequency_Hz"]) for r in tip], curve.frequency, rtol=1e-8)
    assert {r["harmonic"] for r in rows} == {"0", "1", "2", "3"}
    assert {r["stability"] for r in rows} == {"stable"}


def test_a_second_run_does_nothing_and_is_quick(finished):
    rig, out, _ = finished
    before = {
        path: path.stat().st_mtime_ns
        for path in out.rglob("*")
        if path.is_file() and path.name not in ("summary.json", "log.txt")
    }
    first = json.loads((out / "summary.json").read_text())
    started = time.perf_counter()
    result = run_command("run", rig, "--mesh", "small", "--out", out, "--jobs", 2, "--no-accuracy")
    assert result.exit_code == 0, result.output
    assert time.perf_counter() - started < 15
    assert result.output.count("unchanged") == 14
    assert {path: path.stat().st_mtime_ns for path in before} == before
    second = json.loads((out / "summary.json").read_text())
    assert second["timing_s"]["total"] < first["timing_s"]["total"]
    for summary in (first, second):
        summary["timing_s"].pop("total")
        summary.pop("peak_memory_GB")
    assert second == first, "what the stages once cost is still reported"


def must_not_run(*_):
    raise AssertionError("this stage has to come from its file")


def products_again(finished, tmp_path, overrides, functions, **options):
    """Run in a copy of the finished run; returns the run and what it gave."""
    rig, out, _ = finished
    shutil.copytree(out, tmp_path / "out")
    again = Run(
        load_rig(rig, overrides),
        RunOptions("small", tmp_path / "out", workers=2, stability=True, **options),
        Display(Console(file=io.StringIO())),
        functions,
    )
    return again, again.products()


def test_after_a_change_of_friction_no_finite_elements_are_run(finished, tmp_path):
    functions = StageFunctions(*4 * [must_not_run])
    again, products = products_again(finished, tmp_path, {"contact.friction_coefficient": 0.5}, functions)
    assert again.executed[0] == "static_contact"
    curves = {"OOP 0.01 N", "IP 0.01 N"}
    assert set(again.executed[1:]) == curves | {f"{curve}, stability" for curve in curves}
    assert all(curve.product.complete for curve in products.curves)


def test_after_a_change_of_the_damper_the_blade_is_kept(finished, tmp_path):
    functions = StageFunctions(blade=must_not_run)
    change = {"damper.base_height": "2.5 mm"}
    again, products = products_again(finished, tmp_path, change, functions, until=stages.COUPLED_CHECK)
    assert again.executed == ["mesh", "damper", "finite_elements", "coupled_check"]
    assert products.coupled_check.product.largest_difference < 1e-3, "the check has a blade of its own"


def test_after_a_change_of_the_dampers_material_mesh_and_blade_are_kept(finished, tmp_path):
    functions = StageFunctions(mesh=must_not_run, blade=must_not_run)
    material = {"youngs_modulus": "197 GPa", "poissons_ratio": 0.3, "density": "15600 kg/m^3", "loss_factor": 0.001}
    change = {"damper.material": material}
    again, products = products_again(finished, tmp_path, change, functions, until=stages.COUPLED_CHECK)
    assert again.executed == ["damper", "finite_elements", "coupled_check"]
    assert products.coupled_check.product.largest_difference < 1e-3, "the check has the same material"
    plain = load_rig(finished[0])
    assert damper_mass(products.finite_elements.product.reduced) == pytest.approx(
        2 * mass_of_dimensions(plain), rel=1e-6
    )


def test_after_a_change_of_contact_stiffness_the_check_alone_is_made_again(finished, tmp_path):
    functions = StageFunctions(*3 * [must_not_run], static_contact=must_not_run)
    change = {"contact.normal_stiffness": "30000 N/mm^3"}
    again, products = products_again(finished, tmp_path, change, functions, until=stages.COUPLED_CHECK)
    assert again.executed == ["coupled_check"]
    before = json.loads((finished[1] / "summary.json").read_text())["coupled_linear"]["OOP_Hz"]["full"]
    check = products.coupled_check.product
    assert check.full[check.out_of_phase] < before
    assert check.largest_difference < 1e-3


def test_the_check_can_be_left_out(finished, tmp_path):
    functions = StageFunctions(*5 * [must_not_run])
    change = {"contact.normal_stiffness": "30000 N/mm^3"}
    again, products = products_again(
        finished, tmp_path, change, functions, check=False, until=stages.STATIC_CONTACT
    )  # fmt: skip
    assert again.executed == []
    assert products.coupled_check is None


def test_another_force_is_one_more_curve_and_a_damaged_file_is_made_anew(finished, tmp_path):
    rig, out, _ = finished
    shutil.copytree(out, tmp_path / "out")
    (tmp_path / "out" / "stages" / "static_contact.h5").write_bytes(b"damaged")
    functions = StageFunctions(*4 * [must_not_run])
    options = RunOptions("small", tmp_path / "out", modes=("OOP",), forces=(0.01, 0.02), stability=True)
    again = Run(load_rig(rig), options, Display(Console(file=io.StringIO())), functions)
    products = again.products()
    assert again.executed == ["static_contact", "OOP 0.02 N", "OOP 0.02 N, stability"]
    assert [curve.product.force for curve in products.curves] == [0.01, 0.02]
    peaks = [curve.product.peak("blade_right.tip.x")[1] for curve in products.curves]
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-3), "stuck contacts: the receptance is that of a linear system"


def test_an_unstable_peak_and_what_is_not_known_are_said(finished, tmp_path):
    rig, out, _ = finished
    shutil.copytree(out, tmp_path / "out")
    path = tmp_path / "out" / "stages" / "stability_IP_0.01N.h5"
    found, stamp = store.read(path, BranchStability), store.read_stamp(path)
    state = np.full_like(found.state, State.UNSTABLE)
    state[:3] = State.UNKNOWN
    why = np.where(state == State.UNKNOWN, 0, -1)
    store.write(path, replace(found, state=state, reasons=("too little time",), why=why), stamp)
    result = run_command("run", rig, "--mesh", "small", "--out", tmp_path / "out", "--no-pictures", "--no-accuracy")
    assert result.exit_code == 0, "an unstable curve is complete all the same"
    assert re.search(r"stability +IP 0.01 N: the peak at 4[34]\d\.\d\d Hz is unstable", result.output)
    assert not re.search(r"stability +OOP", result.output)
    entry = json.loads((tmp_path / "out" / "summary.json").read_text())["curves"][1]["stability"]
    assert entry["peak"] == "unstable"
    assert entry["unknown_because"] == {"too little time": 3}
    assert entry["points"] == {"stable": 0, "unstable": len(state) - 3, "unknown": 3}
    curve = store.read(tmp_path / "out" / "stages" / "curve_IP_0.01N.h5", ResponseCurve)
    assert entry["unknown_Hz"] == [[curve.frequency[0], curve.frequency[2]]]


def test_a_curve_that_stops_early_is_reported_and_the_run_ends_non_zero(finished, tmp_path):
    rig, out, _ = finished
    shutil.copytree(out, tmp_path / "out")
    path = tmp_path / "out" / "stages" / "curve_IP_0.01N.h5"
    curve, stamp = store.read(path, ResponseCurve), store.read_stamp(path)
    store.write(path, replace(curve, complete=False, stopped="the branch stops at 424 Hz: stalled"), stamp)
    result = run_command("run", rig, "--mesh", "small", "--out", tmp_path / "out", "--no-pictures", "--no-accuracy")
    assert result.exit_code == 1
    assert "not complete IP 0.01 N: the branch stops at 424 Hz: stalled" in result.output
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert [entry["unconverged"] for entry in summary["curves"]] == [0, 1]


def test_without_the_libraries_for_rendering_the_rest_is_made(finished, tmp_path, monkeypatch):
    rig, out, _ = finished
    shutil.copytree(out, tmp_path / "out")
    pictures = tmp_path / "out" / "pictures"
    missing = {"frf_OOP.png", "frf_OOP.svg", "frf_OOP.pdf", *RENDERED}
    before = {path.name for path in pictures.iterdir()}
    assert missing < before
    for name in missing:
        (pictures / name).unlink()
    monkeypatch.setattr(scene, "LIBRARIES", {"libnowhere.so.7": "libnowhere7"})
    result = run_command("run", rig, "--mesh", "small", "--out", tmp_path / "out", "--mode", "OOP", "--no-accuracy")
    assert result.exit_code == 1
    assert "apt-get install libnowhere7" in result.output
    assert {path.name for path in pictures.iterdir()} == before - set(RENDERED)
    plots = [Path(name) for name in PICTURES if name not in RENDERED]
    assert before - set(RENDERED) == {p.with_suffix(ending).name for p in plots for ending in (".png", ".svg", ".pdf")}


def worker_of(pid: int) -> bool:
    """Whether a process has begun a worker."""
    return any("spawn_main" in " ".join(_command_of(child)) for child in psutil.Process(pid).children())


def _command_of(process: psutil.Process) -> list[str]:
    """None of one that has just ended."""
    try:
        return process.cmdline()
    except (psutil.ZombieProcess, psutil.NoSuchProcess):
        return []


def test_what_is_asked_for_twice_is_computed_once(monkeypatch, tmp_path):
    asked = []
    monkeypatch.setattr(predict, "_run", lambda _rig, options, _meter: not asked.append(options))
    twice = ["--mode", "OOP", "--mode", "OOP", "--force", "17 N", "--force", "17000 mN", "--force", "9.6 N"]
    ended = run_command("run", RIG, "--out", tmp_path, *twice)
    assert ended.exit_code == 0, ended.output
    assert (asked[0].modes, asked[0].forces) == (("OOP",), (17.0, 9.6))


def test_an_interruption_is_survived(finished, tmp_path):
    """Ctrl-C of a real process while its worker is busy: the way on is shown, and nothing is left of half a curve."""
    _, out, _ = finished
    rig = short_study(tmp_path, (392, 492), (250, 443))
    shutil.copytree(out, tmp_path / "out")
    command = [
        sys.executable,
        "-m",
        "updamp.pipeline",
        "run",
        str(rig),
        "--mesh",
        "small",
        "--no-pictures",
        "--no-accuracy",
    ]
    command += ["--out", str(tmp_path / "out"), "--mode", "IP", "--force", "17 N", "--jobs", "1", "--no-accuracy"]
    # What a shell starts in the background ignores Ctrl-C, and so would this process's children.
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True
    )
    signal.signal(signal.SIGINT, handler)
    stages = set((tmp_path / "out" / "stages").iterdir())
    try:
        while process.poll() is None and not worker_of(process.pid):
            time.sleep(0.02)
        time.sleep(3)  # it is loading or tracing: both are to end
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the workers as well
        output, _ = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 130, output
    assert "run again" in output
    assert "--force '17 N'" in output
    assert "Traceback" not in output
    assert not [path for path in set((tmp_path / "out" / "stages").iterdir()) - stages if "IP_17N" in path.name]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("run", "missing.toml", "--mesh", "small", "--out", "x"), "missing.toml: no such file"),
        (("run", RIG, "--mesh", "tiny", "--out", "x"), "--mesh tiny: the rig file has small, medium, full"),
        (("run", RIG, "--mesh", "small", "--out", "x", "--mode", "XY"), "--mode XY: the rig file has OOP, IP"),
        (("run", RIG, "--mesh", "small", "--out", "x", "--force", "3.84"), "--force 3.84: state its unit"),
        (("run", RIG, "--mesh", "small", "--out", "x", "--force", "-1 N"), "--force -1 N: out of range"),
        (
            ("run", RIG, "--mesh", "small", "--out", "x", "--until", "lunch"),
            "--until lunch: the stages are mesh, b",
        ),
        (("run", RIG, "--mesh", "small", "--out", "x", "--jobs", "0"), "--jobs 0: at least 1"),
        (("check", "missing.toml"), "missing.toml: no such file"),
        (("show", "nowhere"), "nowhere/summary.json: no such file; make it with: updamp run RIG"),
    ],
    ids=lambda value: value if isinstance(value, str) else None,
)
def test_bad_input_is_one_clean_message(arguments, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run_command(*arguments)
    assert result.exit_code == 2
    assert f"error: {message}" in result.output
    assert "Traceback" not in result.output
    assert list(tmp_path.iterdir()) == [], "nothing is written"


def test_with_debug_the_error_itself_comes_through(tmp_path):
    result = run_command("check", tmp_path / "missing.toml", "--debug")
    assert type(result.exception).__name__ == "RigError"


def test_check_explains_a_rig_file():
    result = run_command("check", RIG)
    assert result.exit_code == 0
    rig = load_rig(RIG)
    alpha = rig.platform.underside_angle
    pressure = 960 / (2 * rig.face_area * (np.cos(alpha) + 0.6 * np.sin(alpha))) / 1e6
    assert f"{pressure:.4f} MPa" in result.output
    assert "material.youngs_modulus" in result.output
    assert "1.97e+11" in result.output


def test_show_and_version(finished):
    shown = run_command("show", finished[1])
    assert shown.exit_code == 0
    assert "modes.free_1F_Hz" in shown.output
    assert "OOP" in shown.output
    assert run_command("--version").output.startswith("updamp ")


def test_until_ends_a_run_early(tmp_path):
    result = run_command("run", RIG, "--mesh", "small", "--out", tmp_path, "--until", "mesh", "--no-pictures")
    assert result.exit_code == 0, result.output
    assert [path.name for path in (tmp_path / "stages").glob("*.h5")] == ["mesh.h5"]
    assert "modes" not in json.loads((tmp_path / "summary.json").read_text())


def test_wall_time_of_parallel_work_counts_overlaps_once():
    assert union_length([(0.0, 2.0), (1.0, 3.0), (10.0, 11.0), (10.2, 10.4)]) == pytest.approx(4.0)
    assert union_length([]) == 0.0


def test_the_meter_sees_memory_and_time():
    with Meter(every=0.01) as meter:
        block = np.ones(40_000_000)  # 320 MB
        time.sleep(0.1)
        held = block.nbytes
    assert meter.peak_memory > held
    assert 0.1 < meter.seconds < 10
    assert meter.interval[1] - meter.interval[0] == pytest.approx(meter.seconds)
