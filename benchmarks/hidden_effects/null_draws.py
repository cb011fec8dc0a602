"""Measurements with nothing hidden: is the model at the true parameters within the scatter, do intervals hold the
truth, does the comparison say that nothing is amiss? Resumable.

.venv/bin/python benchmarks/hidden_effects/null_draws.py [--out FOLDER] [--draws 40] [--jobs 2]
"""

from updamp.parallel.resources import one_thread

one_thread()  # before numpy is loaded: threads make small products many times slower

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray

from updamp.benchmarks.hidden_effects.in_turn import in_turn
from updamp.benchmarks.hidden_effects.layout import read, write_whole
from updamp.benchmarks.virtual_rig.measurement import RIG, make_measurement
from updamp.comparison.compare import damping_share
from updamp.comparison.findings.all_findings import all_findings
from updamp.comparison.findings.findings import Misfit, lack_of_fit, misfits
from updamp.comparison.fit.compared import Compared, compare_at, predict_branches
from updamp.comparison.fit.fit import Fit, fit
from updamp.comparison.fit.numerical_gate import apply_numerical_gate
from updamp.comparison.fit.observations import Plan, plan_of
from updamp.comparison.fit.repeat_scatter import of_repeats
from updamp.comparison.fit.scatter import Scatter, learn
from updamp.comparison.prediction.moved_branch import move_branch
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch, at_sizes, with_patterns
from updamp.measurement.load import load_measurement
from updamp.model.calibration import LOSS_FACTOR
from updamp.workflow.code_version import SEARCH, code_version
from updamp.workflow.compare_run import CompareFiles, comparison_inputs
from updamp.workflow.kept_results import ResultKey, inputs_digest, read_result, write_result
from updamp.workflow.progress import Display

Floats = NDArray[np.float64]

FITTED, FINER = "diagnosis", ("diagnosis_fine", "diagnosis_contacts")
CODE = (*SEARCH, "benchmarks/hidden_effects/null_draws.py")
SEEDS = 9300  # beyond those of the blind benchmark
_WIDER = 0.25  # the windows of all draws lie within the first one's by this share of it to either side
_ROUNDS = 5


@dataclass(frozen=True)
class Draw:
    """measurement: its file; seed: to make it with where it is not there"""

    name: str
    measurement: Path
    seed: int


@dataclass(frozen=True, eq=False)
class Prepared:
    """What all draws share, at the rig file's parameters and in wide windows: branches and their numerical error.

    `updamp compare` works these out for every measurement anew, in its own windows.
    """

    parametrisation: Parametrisation
    branches: tuple[PredictedBranch, ...]

    def moved_to(self, plan: Plan) -> tuple[PredictedBranch, ...]:
        """The branches at a plan's forces, without patterns."""
        plain = Parametrisation(self.parametrisation.base, self.parametrisation.nuisances)
        wide = {b.condition.name: b for b in self.branches}
        start, found = np.zeros(len(plain)), []
        for condition in plan.conditions:
            moved = move_branch(plain, start, replace(wide[condition.name], condition=condition))
            if moved is None:
                raise ValueError(
                    f"{condition.name}: window {condition.window} is not within {wide[condition.name].condition.window}"
                )
            found.append(moved)
        return tuple(found)


@dataclass(frozen=True)
class Result:
    name: str
    sentences: tuple[str, ...]
    seconds: float


def prepare(measurement: Path, models: Path) -> Prepared:
    with Display() as display:
        inputs = comparison_inputs(CompareFiles(RIG, measurement, models), FITTED, 1, display, FINER)
    model, plan = inputs.before_effects, plan_of(inputs.measurement)
    wide = tuple(replace(c, window=_widened(c.window)) for c in plan.conditions)
    plan = replace(plan, conditions=wide)
    return Prepared(*apply_numerical_gate(model, inputs.rig_effects, plan, inputs.finer))


def _widened(window: tuple[float, float]) -> tuple[float, float]:
    low, high = window
    return low - _WIDER * (high - low), high + _WIDER * (high - low)


def compare_draw(draw: Draw, prepared: Path, key: ResultKey, results: Path) -> Result:
    """Compare one measurement and store what is found. key: of the file with what all draws share"""
    started = time.perf_counter()
    results.mkdir(parents=True, exist_ok=True)
    if not draw.measurement.is_file():
        make_measurement(draw.measurement.parent, seed=draw.seed)
    shared: Prepared = read_result(prepared, key, _notice)
    parametrisation = shared.parametrisation
    measurement = load_measurement(draw.measurement, parametrisation.base.components.points, "virtual_rig")
    plan = plan_of(measurement)
    branches = tuple(with_patterns(b, parametrisation.numerics) for b in shared.moved_to(plan))
    truth = at_truth(parametrisation, plan, branches)
    fitted = fit(parametrisation, plan, np.zeros(len(parametrisation)), at_start=branches)
    loss_factor = parametrisation.names.index(LOSS_FACTOR.name)
    after = predict_branches(parametrisation, fitted.u, plan, fitted.compared.branches)
    after = tuple(at_sizes(branch, fitted.u) for branch in after)
    shares = [damping_share(b, loss_factor) for b in after]
    found = misfits(fitted, plan, shares)
    names = {channel.point: channel.name for channel in measurement.channels}
    sentences = tuple(f.text for f in all_findings(fitted, plan, after, found, names, (), (), of_repeats(fitted, plan)))
    write_result(results / f"{draw.name}.pkl", key, (fitted, plan, shares))
    seconds = time.perf_counter() - started
    record = _record(fitted, plan, truth, found)
    whole = {"name": draw.name, "code": key.code, **record, "sentences": list(sentences), "seconds": seconds}
    write_whole(results / f"{draw.name}.json", whole)
    return Result(draw.name, sentences, seconds)


def _record(fitted: Fit, plan: Plan, truth: Compared, found: Sequence[Misfit]) -> dict[str, Any]:
    """In numbers. truth: at the true parameters; found: what calibration leaves"""
    parametrisation, c = fitted.parametrisation, fitted.compared
    n = len(parametrisation.nuisances)
    return {
        "chi2": c.chi2, "values": c.values, "message": fitted.message, "lack_of_fit": lack_of_fit(fitted, plan),
        "truth": {"chi2": truth.chi2, "scatter": truth.scatter.as_numbers()},
        "scatter": c.scatter.as_numbers(),
        "parameters": {
            name: (float(u), float(s))
            for name, u, s in zip(parametrisation.names[:n], fitted.u[:n], fitted.uncertainty[:n], strict=True)
        },
        "numerics": dict(zip(parametrisation.names[n:], fitted.u[n:].tolist(), strict=True)),
        "misfits": [
            [m.direction.quantity, m.direction.test, m.direction.sensor[0], m.relative, m.significance] for m in found
        ],
        "of_runs": [[m.observations.run, m.observations.repeat, float(np.mean(m.residual**2))] for m in c.matched],
    }  # fmt: skip


def at_truth(parametrisation: Parametrisation, plan: Plan, branches: tuple[PredictedBranch, ...]) -> Compared:
    """The comparison with the parameters at their true values, numerical error and scatter fitted."""
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
    known: Annotated[
        Path | None, typer.Option(help="folder of the blind benchmark, for its cases without hidden effects")
    ] = None,
) -> None:
    """Compare them all and print the tables."""
    wanted = _draws(out, draws, known)
    first, prepared, results = wanted[0], out / "prepared.pkl", out / "results"
    if not first.measurement.is_file():
        make_measurement(first.measurement.parent, seed=first.seed)
    key = ResultKey(code_version(*CODE), _digest(RIG, *sorted(first.measurement.parent.iterdir())))
    if read_result(prepared, key, _notice) is None:
        write_result(prepared, key, prepare(first.measurement, out / "models"))
    left = [d for d in wanted if not _is_done(results / f"{d.name}.json", key)]
    work = partial(compare_draw, prepared=prepared, key=key, results=results)
    in_turn(work, left, jobs, "draws", lambda r: f"{r.seconds:.0f} s, {'; '.join(r.sentences) or 'no misfit'}")
    found = [content for d in wanted if (content := read(results / f"{d.name}.json")) is not None]
    typer.echo("\n".join(Summary(tuple(found)).lines()))


def _digest(*files: Path) -> str:
    return inputs_digest(*(sha256(path.read_bytes()).hexdigest() for path in files if path.is_file()))


def _is_done(result: Path, key: ResultKey) -> bool:
    known = read(result)
    if known is not None and known.get("code") != key.code:
        _notice(f"{result}: of another version of updamp; compared anew")
    return known is not None and known.get("code") == key.code


def _notice(sentence: str) -> None:
    typer.echo(sentence, err=True)


def _draws(out: Path, n: int, known: Path | None) -> list[Draw]:
    found = []
    for path in sorted((known / "truth").glob("*.json")) if known is not None else ():
        truth = read(path) or {}
        if truth["kind"] == "none":
            found.append(Draw(path.stem, known / "data" / path.stem / "measurement.toml", truth["seed"]))
    more = range(SEEDS, SEEDS + max(0, n - len(found)))
    found += [Draw(f"seed_{seed}", out / "data" / f"seed_{seed}" / "measurement.toml", seed) for seed in more]
    return found[:n]


if __name__ == "__main__":
    typer.run(main)
