"""The virtual laboratory's measurements: files, what is hidden in them, and what they must not give away."""

import ast
import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.plain_rig import TINY

from updamp.benchmarks.virtual_rig.assembled import assembled
from updamp.benchmarks.virtual_rig.bench import Bench, bench_of
from updamp.benchmarks.virtual_rig.bodies import bodies_of
from updamp.benchmarks.virtual_rig.laboratory import HIDDEN, hidden, jumps, with_hidden
from updamp.benchmarks.virtual_rig.measurement import RIG, make_measurement
from updamp.benchmarks.virtual_rig.periodic import SolverOptions
from updamp.benchmarks.virtual_rig.plan import QUIET, NoiseLevels, PlannedRun, TestPlan
from updamp.benchmarks.virtual_rig.sensors import loose
from updamp.benchmarks.virtual_rig.stepped_sine import StepMotor
from updamp.effects.catalogue import CATALOGUE
from updamp.measurement.load import load_measurement
from updamp.measurement.readers.uff import read_uff
from updamp.model.rig_files import load_rig
from updamp.rig.rig import Rig

QUICK = SolverOptions(harmonics=3, n_time=128, tolerance=1e-6)
PLAN = TestPlan((PlannedRun("IP", 1.0), PlannedRun("OOP", 20.0, upwards=True)), 2, 10, corners=True, harmonics=(1, 3))
SOURCES = Path(RIG).parents[1] / "benchmarks" / "virtual_rig"


@pytest.fixture(scope="module")
def rig() -> Rig:
    return load_rig(RIG, {"mesh.tiny": TINY, "reduction.modes": 10})


@pytest.fixture(scope="module")
def bench(rig: Rig, tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench_of(rig, bodies_of(rig, "tiny", tmp_path_factory.mktemp("bodies")))


@pytest.fixture(scope="module", autouse=True)
def kept_elsewhere(tmp_path_factory: pytest.TempPathFactory) -> object:
    """The laboratory's own store is left alone."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bodies_of, "__defaults__", (tmp_path_factory.mktemp("kept"),))
        yield


def make(out: Path, rig: Rig, noise: NoiseLevels, seed: int = 3, plan: TestPlan = PLAN, names: str = "") -> Path:
    effects = [hidden(name, "strong") for name in names.split()]
    make_measurement(out, plan, effects, seed, noise, rig, "tiny", QUICK)
    return out


@pytest.fixture(scope="module")
def folder(rig: Rig, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make(
        tmp_path_factory.mktemp("noisy"), rig, NoiseLevels(), plan=replace(PLAN, uff=True), names="contact_viscosity"
    )


def test_measurement_is_read_by_updamp(folder: Path) -> None:
    measurement = load_measurement(folder / "measurement.toml")
    assert measurement.pull == 960
    assert {c.point for c in measurement.channels} == set(PLAN.channels.values())
    assert [(run.name, run.repeat, run.upwards) for run in measurement.runs if run.repeat == 2] == [
        ("IP 1 N", 2, False),
        ("OOP 20 N up", 2, True),
    ]
    for run in measurement.runs:
        assert (len(run), run.held, run.harmonics) == (10, "force", (1, 3))
        assert np.abs(run.force) == pytest.approx(run.level, rel=0.02)
        receptance = run.receptance("tip_right")
        phase = np.angle(receptance[len(run) // 2])  # the sweep is laid about the resonance
        # Out of phase the blades turn about the damper: below it, where the shaker pulls, they move against their tips.
        assert np.sin(phase) * (-1 if run.mode == "IP" else 1) > 0.6


def test_universal_file_holds_the_same(folder: Path) -> None:
    measurement = load_measurement(folder / "measurement.toml")
    sweeps = {(s.run, s.repeat): s for s in read_uff(folder / "sweeps.uff", ("force", "tip_left"), None)}
    for run in measurement.runs:
        sweep = sweeps[run.name, run.repeat]
        order = np.argsort(sweep.frequency)
        assert np.sort(run.frequency) == pytest.approx(sweep.frequency[order], rel=1e-12)
        wanted = run.amplitude("tip_left", 3)[np.argsort(run.frequency)]
        assert sweep.channels["tip_left"].amplitude[1][order] == pytest.approx(wanted, rel=1e-8)


def test_truth_is_in_the_sealed_file_alone(folder: Path) -> None:
    truth = json.loads((folder / "sealed.json").read_text())
    assert truth["hidden"] == [
        {"name": "contact_viscosity", "values": HIDDEN["contact_viscosity"].strengths["strong"], "strength": "strong"}
    ]
    assert len(truth["assemblies"]) == 2
    assert len({draw["friction"] for draw in truth["assemblies"]}) == 2
    assert len({tuple(run["drift"]) for run in truth["runs"]}) == 4
    for name in ("measurement.toml", "sweeps.csv"):
        assert "viscosity" not in (folder / name).read_text()


def test_same_seed_same_files_another_seed_another(rig: Rig, folder: Path, tmp_path: Path) -> None:
    again = make(tmp_path / "again", rig, NoiseLevels(), names="contact_viscosity")
    assert (again / "sweeps.csv").read_text() == (folder / "sweeps.csv").read_text()
    other = make(tmp_path / "other", rig, NoiseLevels(), seed=4, names="contact_viscosity")
    assert (other / "sweeps.csv").read_text() != (folder / "sweeps.csv").read_text()


def test_quiet_laboratory_repeats_itself_and_holds_the_force(rig: Rig, tmp_path: Path) -> None:
    first, second = (
        run for run in load_measurement(make(tmp_path, rig, QUIET) / "measurement.toml").runs if run.mode == "OOP"
    )
    assert np.abs(first.force) == pytest.approx(20, rel=1e-8)
    assert first.receptance("tip_left") == pytest.approx(second.receptance("tip_left"), rel=1e-5)


def test_noise_is_as_large_as_stated(rig: Rig, tmp_path: Path) -> None:
    plan = TestPlan((PlannedRun("IP", 0.5),), 2, 400)
    noisy = make(tmp_path / "a", rig, replace(QUIET, relative=0.02, floor=1e-8), plan=plan)
    sizes = []
    for run in load_measurement(noisy / "measurement.toml").runs:
        values = run.amplitude("tip_right") / np.exp(1j * np.angle(run.force))
        error = np.diff(values, 3) / np.sqrt(20)
        wanted = np.hypot(0.02 * np.abs(values), 1e-8)[1:-2]
        sizes += [(error.real / wanted).std(), (error.imag / wanted).std()]
    assert np.mean(sizes) == pytest.approx(1, abs=0.07)


def test_all_of_the_catalogue_can_be_hidden_and_six_kinds_that_are_not_in_it() -> None:
    assert {name for name, effect in HIDDEN.items() if effect.in_catalogue} <= set(CATALOGUE)
    assert {e.catalogue_name for e in HIDDEN.values() if e.in_catalogue or e.renamed} == set(CATALOGUE)
    assert sum(not (effect.in_catalogue or effect.renamed) for effect in HIDDEN.values()) >= 6


@pytest.mark.parametrize("name", HIDDEN)
def test_every_effect_is_seen_and_grows_with_its_strength(name: str, bench: Bench, rig: Rig) -> None:
    ip, oop = assembled(bench).stuck_frequencies(2)
    places = ((0.998 * ip, 2.0), (0.998 * oop, 15.0))

    def tips(bench: Bench) -> np.ndarray:
        motions = [StepMotor(assembled(bench), QUICK).step(f, force) for f, force in places]
        left, right = ([m.response(f"blade_{side}.tip.x")[:1] for m in motions] for side in ("left", "right"))
        return np.concatenate([*(loose(y, bench.loose_gain) for y in left), *right])

    plain = tips(bench)
    change = [
        np.abs(tips(with_hidden(bench, [hidden(name, strength)], rig).in_run(0.5)) / plain - 1).max()
        for strength in ("weak", "strong")
    ]
    assert change[1] > 0.001
    assert change[0] < change[1]


def test_faces_carry_what_they_carried(bench: Bench, rig: Rig) -> None:
    for name in ("pressure_crown", "edge_gap"):
        n0 = with_hidden(bench, [hidden(name, "strong")], rig).patches.n0
        assert n0.std() > 0.05 * n0.mean()
        for side in (0, 1):
            on = bench.bodies.face == side
            assert n0[on].sum() == pytest.approx(bench.patches.n0[on].sum(), rel=1e-9)


def test_jump_is_recorded() -> None:
    response = np.concatenate([np.linspace(1, 2, 10), np.linspace(8, 7, 10)])
    assert jumps(np.arange(20.0), response) == (9.0,)
    assert jumps(np.arange(20.0), np.exp(np.linspace(0, 3, 20))) == ()


def test_unknown_names_are_refused() -> None:
    with pytest.raises(ValueError, match="no effect 'rust'"):
        hidden("rust", "weak")
    with pytest.raises(ValueError, match="'huge' of 'edge_gap'"):
        hidden("edge_gap", "huge")
    with pytest.raises(ValueError, match="mode torsion"):
        make_measurement(Path("unused"), TestPlan((PlannedRun("torsion", 1.0),)))


# What the fitted model is made of and judged by. Rig files are read by the same code: `updamp.model.rig_files`.
NOT_THE_LABORATORYS = tuple(
    f"updamp.{room}."
    for room in ("api", "hbm", "effects", "model.build", "model.calibration", "measurement", "comparison", "diagnosis")
)


def test_laboratory_knows_neither_updamps_solver_nor_its_diagnosis() -> None:
    for source in SOURCES.glob("*.py"):
        for node in ast.walk(ast.parse(source.read_text())):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            assert not [n for n in names if f"{n}.".startswith(NOT_THE_LABORATORYS)], source


def test_every_line_of_the_csv_is_complete(folder: Path) -> None:
    with (folder / "sweeps.csv").open() as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == 2 * 2 * 10 * (1 + 4 * 2)
    assert all(value != "" for line in lines for value in line.values())
