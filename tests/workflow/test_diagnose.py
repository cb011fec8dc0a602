"""`updamp diagnose` from files to files, on a beam whose quadratic damping two effects describe alike."""

import io
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from rich.console import Console
from support import measured_beam

from updamp.diagnosis.candidate_models.baseline import Baseline
from updamp.diagnosis.candidate_models.fit_tasks import FitTask, OnFitted
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.verdict import VERDICT_JSON, Verdict
from updamp.effects.catalogue import JOINTS, catalogue
from updamp.parallel import processes
from updamp.workflow import diagnose_run as module
from updamp.workflow.comparison_inputs import CompareFiles, comparison_inputs
from updamp.workflow.diagnose_run import DiagnoseOptions, diagnose
from updamp.workflow.progress import Display

TWINS = {"joint_quadratic", "drag"}
# Beside the user's own. Every one of them is fitted, here where two describe the data and one does not; a search among
# all of them, faults of the measurement too, is in tests/effects/test_faults.py.
SOUGHT = ("joint_quadratic", "joint_cubic")
Short = Callable[..., Verdict]


def diagnosis(folder: Path, out: str, **changes: Any) -> Verdict:
    """Fits are to the first mode alone; the second one is for judging."""
    options = {
        "own": (folder / "drag.py",),
        "held_out_modes": ("second",),
        **changes,
    }
    files = CompareFiles(folder / "beam.toml", folder / "measurement.toml", folder / out)
    return diagnose(files, "full", DiagnoseOptions(**options), Console(file=io.StringIO()))


@pytest.fixture(scope="module", autouse=True)
def few_effects() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "catalogue", lambda: {name: catalogue()[name] for name in SOUGHT})
        yield


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("beam")
    measured_beam.write(found)
    (found / "drag.py").write_text(measured_beam.TWIN, encoding="utf-8")
    return found


@pytest.fixture(scope="module")
def verdict(folder: Path) -> Verdict:
    return diagnosis(folder, "one")


@pytest.fixture(scope="module")
def short_diagnosis(short_folder: Path) -> Short:
    """A quarter of the work: fewer points, one assembly, and of the catalogue one effect beside the user's own."""

    def made(out: str, **changes: Any) -> Verdict:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(module, "catalogue", lambda: {"joint_quadratic": JOINTS["joint_quadratic"]})
            return diagnosis(short_folder, out, **{"report": False, **changes})

    return made


@pytest.fixture(scope="module")
def short_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("short")
    measured_beam.write(found, repeats=1, points=12)
    (found / "drag.py").write_text(measured_beam.TWIN, encoding="utf-8")
    return found


@pytest.fixture(scope="module")
def in_this_process(short_diagnosis: Short) -> Verdict:
    found = short_diagnosis("one", report=True)
    assert (found.verdict, set(found.group)) == ("inseparable", TWINS)
    return found


def same(one: Verdict, other: Verdict) -> None:
    """To the last digit; the next measurement and the missing force are for the report alone."""
    first, second = (VERDICT_JSON.to_json(replace(v, next_measurement=(), missing_forces=())) for v in (one, other))
    assert first == second


def parameters(verdict: Verdict) -> Mapping[str, float]:
    return {p.name: p.value for c in verdict.candidates if c.accepted for p in c.parameters}


@pytest.mark.long
def test_a_mode_that_no_fit_has_seen_is_predicted(verdict: Verdict) -> None:
    assert (verdict.verdict, set(verdict.group)) == ("inseparable", TWINS)
    assert verdict.error.held_out_before > 5
    assert verdict.error.held_out_after < 1
    before, after = verdict.error.held_out_before, verdict.error.held_out_after
    assert f"on second, of which the fit saw no run, from {before:.1f} to {after:.2f}" in verdict.sentence
    assert parameters(verdict)["coefficient"] == pytest.approx(measured_beam.DAMPING, rel=0.02)
    assert {s.mode for s in verdict.signatures} == {"first"}
    assert verdict.provenance["held out"] == "second 1 N, second 4 N"
    assert verdict.provenance["solved with"].startswith("harmonics 1")


def test_the_next_measurement_is_looked_for_and_shown(in_this_process: Verdict, short_folder: Path) -> None:
    (proposed,) = in_this_process.next_measurement
    assert set(proposed.effects) == TWINS
    assert proposed.separation < 0.1
    assert proposed.sentence.startswith("no run that was looked at tells")
    stored = VERDICT_JSON.read(short_folder / "one" / "diagnosis.json")
    assert stored.next_measurement == in_this_process.next_measurement
    assert proposed.sentence in (short_folder / "one" / "report.html").read_text(encoding="utf-8")


def test_nothing_is_done_again(
    in_this_process: Verdict, short_diagnosis: Short, monkeypatch: pytest.MonkeyPatch
) -> None:
    def must_not_run(*_: object) -> None:
        raise AssertionError("this is known")

    def nothing_to_run(_start: Baseline, _criteria: Criteria, tasks: Sequence[FitTask], _done: OnFitted) -> list[None]:
        assert not tasks, "these fits are known"
        return []

    monkeypatch.setattr(module, "FitRunnerOf", lambda _: nothing_to_run)
    monkeypatch.setattr(module, "_report", lambda *_: None)
    for name in ("next_measurements", "baseline"):
        monkeypatch.setattr(module, name, must_not_run)
    again = short_diagnosis("one", report=True)
    same(again, in_this_process)
    assert again.next_measurement == in_this_process.next_measurement


def test_what_is_known_is_dropped_when_a_user_s_effect_changes(tmp_path: Path) -> None:
    """The rig file's own, whose text stays, and one that is looked for."""
    rig, measurement = measured_beam.write(tmp_path, repeats=1)
    taken = '\n[[effects]]\nname = "drag"\nfile = "drag.py"\nvalues = { half = 5 }\n'
    rig.write_text(measured_beam.RIG + taken, encoding="utf-8")
    files, digests = CompareFiles(rig, measurement, tmp_path / "out"), []
    for i, (factor, sought) in enumerate(((2, 2), (3, 2), (3, 3), (3, 3))):
        (tmp_path / "drag.py").write_text(measured_beam.TWIN.replace("2 *", f"{factor} *"), encoding="utf-8")
        looked_for = measured_beam.TWIN.replace('"drag"', '"more"').replace("2 *", f"{sought} *")
        (tmp_path / "more.py").write_text(looked_for, encoding="utf-8")
        options = DiagnoseOptions(own=(tmp_path / "more.py",), jobs=1 + i)
        with Display(Console(file=io.StringIO())) as display:
            inputs = comparison_inputs(files, "full", 1, display, ())
        assert [one.effect.name for one in inputs.rig_effects] == ["drag"]
        digests.append(module._digest(files, "full", options, inputs, module._effects(inputs, options)))
    assert len(set(digests)) == 3
    assert digests[2] == digests[3], "how many processes there are makes no difference"


class BegunAnewError(Exception):
    """In the place of what takes long."""


def test_what_another_version_has_found_is_not_used(
    in_this_process: Verdict, short_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert in_this_process.group, "a search is kept"
    older = short_folder / "older" / "search"
    shutil.copytree(short_folder / "one" / "search", older)

    def begun(*_: object) -> None:
        raise BegunAnewError

    monkeypatch.setattr(module, "baseline", begun)
    monkeypatch.setattr(module, "code_version", lambda *_: "of another day")
    said = io.StringIO()
    files = CompareFiles(short_folder / "beam.toml", short_folder / "measurement.toml", short_folder / "older")
    with pytest.raises(BegunAnewError):
        diagnose(files, "full", DiagnoseOptions(own=(short_folder / "drag.py",)), Console(file=said, width=500))
    assert f"the search kept in {older} was made by another version of updamp" in said.getvalue()
    assert list(older.iterdir()) == []


def test_files_that_the_rig_file_names_count_and_its_comments_do_not(tmp_path: Path) -> None:
    rig, film = tmp_path / "rig.toml", tmp_path / "film.csv"
    text = (Path(__file__).parents[1] / "data" / "short_faces.toml").read_text(encoding="utf-8")
    uniform = 'model = "uniform"'
    assert uniform in text
    mapped = text.replace(uniform, 'model = "polynomial"\nmap = "film.csv"')
    inputs: Any = SimpleNamespace(measurement=SimpleNamespace(hashes={"sweeps.csv": "..."}))

    def digest(text: str, pressure: float) -> str:
        rig.write_text(text, encoding="utf-8")
        samples = [f"{s / 4},{z / 4},{pressure + s}" for s in range(-3, 4) for z in range(-3, 4)]
        film.write_text("\n".join(["s,z,pressure", *samples]), encoding="utf-8")
        files = CompareFiles(rig, tmp_path / "measurement.toml", tmp_path / "out")
        return module._digest(files, "small", DiagnoseOptions(), inputs, ())

    known = digest(mapped, 5.0)
    assert digest(f"# looked at again\n{mapped}", 5.0) == known
    assert digest(mapped, 6.0) != known
    assert digest(mapped.replace("[load]", "[load] # heavy"), 5.0) == known


@pytest.mark.long
def test_two_processes_find_the_same(in_this_process: Verdict, short_diagnosis: Short) -> None:
    same(short_diagnosis("two", jobs=2), in_this_process)


@pytest.mark.long
def test_a_dask_cluster_finds_the_same(in_this_process: Verdict, short_diagnosis: Short) -> None:
    distributed = pytest.importorskip("distributed", reason="Dask is optional: pip install 'updamp[cluster]'")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        found = short_diagnosis("dask", scheduler=cluster.scheduler_address)
    same(found, in_this_process)


def test_a_scheduler_without_workers_is_not_waited_for_for_ever(
    in_this_process: Verdict, short_diagnosis: Short, monkeypatch: pytest.MonkeyPatch
) -> None:
    distributed = pytest.importorskip("distributed", reason="Dask is optional: pip install 'updamp[cluster]'")
    assert in_this_process.verdict == "inseparable", "what is known up to the fits is read back"
    monkeypatch.setattr(processes, "_PATIENCE", 0.5)
    with (
        distributed.LocalCluster(n_workers=0, dashboard_address=None) as cluster,
        pytest.raises(ValueError, match=r"no worker has come in 0.5 s; start one: dask worker tcp://"),
    ):
        short_diagnosis("one", scheduler=cluster.scheduler_address)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"held_out_modes": ("third",)}, "no mode 'third' to hold out; there are first, second"),
        ({"held_out_modes": ("first", "second")}, "none is left to fit to"),
        ({"held_out": ("first 3 N",)}, "no run 'first 3 N' to hold out"),
    ],
)
def test_what_cannot_be_held_out_is_refused(folder: Path, changes: dict[str, Any], message: str) -> None:
    """Before anything is built."""
    with pytest.raises(ValueError, match=message):
        diagnosis(folder, "refused", **changes)
    assert not (folder / "refused").exists()
