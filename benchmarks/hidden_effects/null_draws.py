"""Measurements with nothing hidden: is the model at the true parameters within the scatter, do intervals hold the
truth, does the comparison say that nothing is amiss? Resumable.

.venv/bin/python benchmarks/hidden_effects/null_draws.py [--test scarce] [--out FOLDER] [--draws 40] [--first-seed N]
"""

from updamp.parallel.resources import one_thread

one_thread()  # before numpy is loaded: threads make small products many times slower

import time
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray
from rich.console import Console

from updamp.benchmarks.hidden_effects.fitted_model import FINER
from updamp.benchmarks.hidden_effects.in_turn import in_turn
from updamp.benchmarks.hidden_effects.kinds_of_test import EASY, KINDS_OF_TEST, KindOfTest
from updamp.benchmarks.hidden_effects.layout import read, write_whole
from updamp.benchmarks.virtual_rig.measurement import make_measurement
from updamp.comparison.compare import CalibrationResult, calibrate, comparison_of
from updamp.comparison.fit.compared import Compared, compare_at
from updamp.comparison.fit.scatter import Scatter, learn
from updamp.model.rig_files import load_rig
from updamp.workflow.code_version import SEARCH, code_version
from updamp.workflow.comparison_inputs import CompareFiles, comparison_inputs
from updamp.workflow.progress import Display

Floats = NDArray[np.float64]

FITTED = "diagnosis"
CODE = (*SEARCH, "benchmarks/hidden_effects/null_draws.py")
SEEDS = 9300  # beyond those of the blind benchmark
_ROUNDS = 5


@dataclass(frozen=True)
class Draw:
    """measurement: its file; seed: to make it with where it is not there; test: what is measured, and of which rig"""

    name: str
    measurement: Path
    seed: int
    test: KindOfTest = EASY

    def make(self) -> None:
        """Where it is not there."""
        if not self.measurement.is_file():
            plan, noise, rig = self.test.plan, self.test.noise, load_rig(self.test.rig)
            make_measurement(self.measurement.parent, plan, seed=self.seed, noise=noise, rig=rig)


@dataclass(frozen=True)
class Result:
    name: str
    sentences: tuple[str, ...]
    seconds: float


def compare_draw(draw: Draw, models: Path, code: str, results: Path) -> Result:
    """Compare one measurement as `updamp compare` does and store what is found. models: folder of the stages' files"""
    started = time.perf_counter()
    results.mkdir(parents=True, exist_ok=True)
    draw.make()
    with Display(Console(quiet=True)) as display:
        files = CompareFiles(draw.test.rig, draw.measurement, models)
        inputs = comparison_inputs(files, FITTED, 1, display, FINER[FITTED])
    calibrated = calibrate(
        inputs.before_effects, inputs.measurement, finer=inputs.finer, rig_effects=inputs.rig_effects
    )
    sentences = tuple(f.text for f in comparison_of(calibrated, inputs.measurement).findings)
    seconds = time.perf_counter() - started
    whole = {"name": draw.name, "code": code, **_record(calibrated), "sentences": list(sentences), "seconds": seconds}
    write_whole(results / f"{draw.name}.json", whole)
    return Result(draw.name, sentences, seconds)


def _record(calibrated: CalibrationResult) -> dict[str, Any]:
    """In numbers: what was fitted, and the comparison at the true parameters."""
    fitted, truth = calibrated.fit, at_truth(calibrated)
    parametrisation, c = fitted.parametrisation, fitted.compared
    n = len(parametrisation.nuisances)
    return {
        "chi2": c.chi2, "values": c.values, "message": fitted.message,
        "truth": {"chi2": truth.chi2, "scatter": truth.scatter.as_numbers()},
        "scatter": c.scatter.as_numbers(),
        "parameters": {
            name: (float(u), float(s))
            for name, u, s in zip(parametrisation.names[:n], fitted.u[:n], fitted.uncertainty[:n], strict=True)
        },
        "numerics": dict(zip(parametrisation.names[n:], fitted.u[n:].tolist(), strict=True)),
        "of_runs": [[m.observations.run, m.observations.repeat, float(np.mean(m.residual**2))] for m in c.matched],
    }  # fmt: skip


def at_truth(calibrated: CalibrationResult) -> Compared:
    """The comparison with the parameters at their true values, numerical error and scatter fitted."""
    parametrisation, plan, branches = calibrated.given, calibrated.plan, calibrated.before
    n = len(parametrisation.nuisances)
    prior = Scatter({x.name: x.scatter for x in parametrisation.nuisances})
    u = np.zeros(len(parametrisation))
    now = compare_at(parametrisation, u, plan, branches, prior)
    for _ in range(_ROUNDS):
        residual, columns = now.equations()
        patterns = columns[:, n:]
        information = patterns.T @ patterns + np.eye(patterns.shape[1])
        u = u.copy()
        u[n:] += np.linalg.solve(information, patterns.T @ residual - u[n:])
        now = compare_at(parametrisation, u, plan, branches, now.scatter, now.offsets)
        now = replace(now, scatter=learn(now.assemblies, prior))
    return compare_at(parametrisation, u, plan, branches, now.scatter, now.offsets)


@dataclass(frozen=True, eq=False)
class Summary:
    results: tuple[dict[str, Any], ...]

    @cached_property
    def z(self) -> dict[str, Floats]:
        """Parameter -> (n_draws,) distance from the truth, in standard deviations."""
        names = self.results[0]["parameters"]
        return {x: np.array([r["parameters"][x][0] / r["parameters"][x][1] for r in self.results]) for x in names}

    def lines(self) -> list[str]:
        """Tables in Markdown."""
        quiet = sum(not r["sentences"] for r in self.results)
        sentences = [f"- {r['name']}: {'; '.join(r['sentences'])}" for r in self.results if r["sentences"]]
        return [*self._chi2(), "", *self._coverage(), "", f"No misfit: {quiet} of {len(self.results)}", *sentences]

    def _chi2(self) -> list[str]:
        rows = [
            "| reduced chi-square | mean | lowest | highest | within 0.8-1.25 | noise factor |",
            "|---|---|---|---|---|---|",
        ]
        at_truth = [r["truth"] | {"values": r["values"], "parameters": ()} for r in self.results]
        for name, results in (("calibrated", self.results), ("at the true parameters", at_truth)):
            of = np.array([r["chi2"] / (r["values"] - len(r["parameters"])) for r in results])
            noise = np.array([r["scatter"]["sensor noise"] for r in results])
            inside = f"{np.sum((of > 0.8) & (of < 1.25))} of {len(of)}"
            span = f"{noise.mean():.2f} ({noise.min():.2f}-{noise.max():.2f})"
            rows.append(f"| {name} | {of.mean():.3f} | {of.min():.3f} | {of.max():.3f} | {inside} | {span} |")
        return rows

    def _coverage(self) -> list[str]:
        rows, held = ["| parameter | truth within 95 % | mean z | std z | half-width |", "|---|---|---|---|---|"], 0
        for name, z in self.z.items():
            inside = int(np.sum(np.abs(z) < 1.96))
            held += inside
            width = 196 * float(np.median([r["parameters"][name][1] for r in self.results]))
            rows.append(f"| {name} | {inside} of {len(z)} | {z.mean():+.2f} | {z.std():.2f} | {width:.2g} % |")
        return [*rows, f"| all | {100 * held / sum(len(z) for z in self.z.values()):.1f} % | | | |"]


def main(
    out: Annotated[Path, typer.Option(help="for measurements, models and results")] = Path("results/null_draws"),
    draws: int = 40,
    jobs: Annotated[int, typer.Option(min=1, help="processes")] = 1,
    first_seed: Annotated[int, typer.Option(help="of the draws; one that nobody has looked at yet")] = SEEDS,
    known: Annotated[
        Path | None, typer.Option(help="folder of the blind benchmark, for its cases without hidden effects")
    ] = None,
    test: Annotated[str, typer.Option(help=f"kind of test: {', '.join(KINDS_OF_TEST)}")] = EASY.name,
) -> None:
    """Compare them all and print the tables."""
    if test not in KINDS_OF_TEST:
        raise typer.BadParameter(f"'{test}': one of {', '.join(KINDS_OF_TEST)}", param_hint="--test")
    out = out if test == EASY.name else out / test
    wanted = _draws(out, draws, known, first_seed, KINDS_OF_TEST[test])
    models, results = out / "models", out / "results"
    code = code_version(*CODE)
    _make_models(wanted[0], models)
    left = [d for d in wanted if not _is_done(results / f"{d.name}.json", code)]
    work = partial(compare_draw, models=models, code=code, results=results)
    in_turn(work, left, jobs, "draws", lambda r: f"{r.seconds:.0f} s, {'; '.join(r.sentences) or 'no misfit'}")
    found = [content for d in wanted if (content := read(results / f"{d.name}.json")) is not None]
    typer.echo("\n".join(Summary(tuple(found)).lines()))


def _make_models(first: Draw, models: Path) -> None:
    """Once, before several processes look for them."""
    first.make()
    with Display() as display:
        comparison_inputs(CompareFiles(first.test.rig, first.measurement, models), FITTED, 1, display, FINER[FITTED])


def _is_done(result: Path, code: str) -> bool:
    known = read(result)
    if known is not None and known.get("code") != code:
        typer.echo(f"{result}: of another version of updamp; compared anew", err=True)
    return known is not None and known.get("code") == code


def _draws(out: Path, n: int, known: Path | None, first_seed: int, test: KindOfTest) -> list[Draw]:
    found = []
    for path in sorted((known / "truth").glob("*.json")) if known is not None else ():
        truth = read(path) or {}
        if truth["kind"] == "none" and truth.get("test", EASY.name) == test.name:
            found.append(Draw(path.stem, known / "data" / path.stem / "measurement.toml", truth["seed"], test))
    more = range(first_seed, first_seed + max(0, n - len(found)))
    found += [Draw(f"seed_{seed}", out / "data" / f"seed_{seed}" / "measurement.toml", seed, test) for seed in more]
    return found[:n]


if __name__ == "__main__":
    typer.run(main)
