"""Which hidden effects can be seen at all: expected score and visibility, from the laboratory alone.

.venv/bin/python benchmarks/hidden_effects/detectability.py [--draw N] [--out FOLDER] [--only ...]

The signature of an effect is the change of log(receptance) that it makes at the points of a measurement, without noise.
Its covariance is that of the mean over the assemblies: noise of the sensors, and scatter of assemblies and drift of
runs as the laboratory draws them. What nuisance parameters can imitate counts as covariance too, with the deviations
that updamp allows them, and so does the error of the model that is fitted: what its mesh, once calibrated, and its
harmonics change, run by run. Expected score z = sqrt(s^T C^-1 s); visibility: z over what it would be without these.

First order in the nuisance parameters reaches no further than a share of a resonance's half-width, and an effect may
shift resonances by several. So the signature is that of a bench whose nuisance parameters have brought the stuck
resonances back, less what these do to first order: their prior has the same cost wherever the curves are linearised.

All curves are the laboratory's own, so what is detectable does not depend on how well the diagnosis works.
"""

from updamp.parallel.resources import one_thread

one_thread()  # before numpy is loaded: threads make small products many times slower

import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import cache, partial
from operator import attrgetter
from pathlib import Path
from typing import Annotated

import numpy as np
import scipy.linalg
import scipy.optimize
import typer
from numpy.typing import NDArray

from updamp.benchmarks.hidden_effects.cases import Case
from updamp.benchmarks.hidden_effects.in_turn import in_turn
from updamp.benchmarks.hidden_effects.kinds_of_test import EASY, KINDS_OF_TEST, KindOfTest
from updamp.benchmarks.hidden_effects.layout import Layout, read, write_whole
from updamp.benchmarks.hidden_effects.version_2 import Draw, Only, chosen_cases
from updamp.benchmarks.virtual_rig.assembled import assembled
from updamp.benchmarks.virtual_rig.bench import BODIES, Bench, bench_of
from updamp.benchmarks.virtual_rig.bodies import LABORATORY, bodies_of
from updamp.benchmarks.virtual_rig.laboratory import grid, quick_sweep, windows, with_hidden
from updamp.benchmarks.virtual_rig.periodic import NotSolvedError, SolverOptions
from updamp.benchmarks.virtual_rig.plan import NoiseLevels, TestPlan
from updamp.benchmarks.virtual_rig.sensors import LOOSE, loose
from updamp.benchmarks.virtual_rig.stepped_sine import StepMotor
from updamp.model.rig_files import load_rig
from updamp.workflow.code_version import code_version

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Factor:
    """A factor on a quantity. scatter: the deviation of its logarithm between assemblies, of a test's noise; allowed:
    what updamp's fit allows it (comparison/prediction/parameters.py); step: of the logarithm, for the difference"""

    scatter: Callable[[NoiseLevels], float]
    allowed: float
    step: float
    apply: Callable[[Bench, float], Bench]


def _entry(name: str) -> Callable[[Bench, float], Bench]:
    return lambda bench, factor: bench.with_patches(**{name: factor * getattr(bench.patches, name)})


CODE = (*LABORATORY, "benchmarks/hidden_effects/detectability.py")

# Harmonics and samples of the model that is fitted.
COARSE = SolverOptions(3, 128)

FACTORS = (
    Factor(attrgetter("friction"), 0.3, 0.02, _entry("mu")),
    Factor(attrgetter("tangential"), 0.7, 0.02, _entry("kt")),
    Factor(attrgetter("normal"), 0.7, 0.02, _entry("kn")),
    Factor(attrgetter("preload"), 0.02, 0.01, _entry("n0")),
    Factor(attrgetter("youngs_modulus"), 0.01, 1e-4, lambda b, f: b.tuned(**dict.fromkeys(BODIES, float(np.sqrt(f))))),
    Factor(lambda _: 0.0, 0.5, 0.02, lambda bench, f: replace(bench, loss_factor=f * bench.loss_factor)),
)
E_MODULUS = 4  # place of Young's modulus, whose half is a drift of the frequencies

# Share of a half-width to which resonances are brought back: what first order leaves out goes with its square.
ALIGNED = 0.01


@dataclass(frozen=True)
class Expected:
    """score: expected, in standard deviations; visibility: 0 to 1"""

    score: float
    visibility: float


@dataclass(frozen=True, eq=False)
class Background:
    """Of a bench with nothing hidden, in a test.

    frequencies: (runs, points) [Hz]; options: of the laboratory's solver
    plain: (runs, channels, points) log receptance
    columns: (n, factors) derivatives by the logarithms of FACTORS
    noise: covariance of one mean over the assemblies, with scatter; allowed: with nuisance parameters and the fitted
        model's error too
    """

    test: KindOfTest
    bench: Bench
    frequencies: Floats
    options: SolverOptions
    plain: Complex
    columns: Floats
    noise: Floats
    allowed: Floats

    def signature(self, changed: Bench) -> Floats:
        """(runs * channels * points * 2,) change of log(receptance), real and imaginary; 0 where nothing settles"""
        logs = bringing_back(changed, self.bench)
        there = log_receptance(scaled(changed, logs), self.frequencies, self.test.plan, self.options)
        change = as_real(difference(there, self.plain))
        return np.where(np.isfinite(change), change - self.columns @ logs, 0.0)


def log_receptance(
    bench: Bench, frequencies: Floats, plan: TestPlan, options: SolverOptions = SolverOptions()
) -> Complex:
    """(runs, channels, points), nan where no motion is found; swept as the laboratory does"""
    found = np.full((len(plan.runs), len(plan.channels), plan.points), np.nan, dtype=complex)
    rig = assembled(bench)
    for r, (run, grid_of_run) in enumerate(zip(plan.runs, frequencies, strict=True)):
        motor = StepMotor(assembled(bench.in_run(plan.place(run))) if bench.running_in else rig, options)
        for i in range(plan.points)[:: 1 if run.upwards else -1]:
            try:
                motion = motor.step(float(grid_of_run[i]), run.force)
            except NotSolvedError:
                continue
            for c, (name, point) in enumerate(plan.channels.items()):
                gain = bench.loose_gain if name == LOOSE else 0.0
                found[r, c, i] = np.log(loose(motion.response(point)[:1], gain)[0] / run.force)
    return found


def difference(a: Complex, b: Complex) -> Complex:
    """Of logarithms: the phase is the smaller one of two."""
    d = a - b
    return d.real + 1j * np.angle(np.exp(1j * d.imag))


def as_real(values: Complex) -> Floats:
    return np.stack([values.real, values.imag], axis=-1).ravel()


@cache
def background(name: str, preset: str, fitted: str) -> Background:
    """Of a kind of test, by name, and the laboratory's mesh, for a model of another one."""
    test = KINDS_OF_TEST[name]
    rig, plan = load_rig(test.rig), test.plan
    bench = bench_of(rig, bodies_of(rig, preset))
    still = assembled(bench)
    frequencies = np.array([grid(*quick_sweep(still, run), plan, windows(still)[run.mode]) for run in plan.runs])
    return background_of(bench, like(bench_of(rig, bodies_of(rig, fitted)), bench), test, frequencies)


def background_of(
    bench: Bench, model: Bench, test: KindOfTest, frequencies: Floats, options: SolverOptions = SolverOptions()
) -> Background:
    """model: of the mesh that is fitted; frequencies: (runs, points) [Hz]"""
    of = partial(log_receptance, frequencies=frequencies, plan=test.plan)
    plain = of(bench, options=options)
    stepped = [of(f.apply(bench, np.exp(f.step)), options=options) for f in FACTORS]
    columns = [np.nan_to_num(as_real(difference(one, plain))) / f.step for f, one in zip(FACTORS, stepped, strict=True)]
    J = np.array(columns).T
    noise, allowed = covariances(plain, J, test)
    for other in (of(model, options=options), of(bench, options=COARSE)):
        error = np.nan_to_num(as_real(difference(other, plain)))[:, None] * _of_each_run(plain.shape)
        allowed = allowed + error @ error.T
    return Background(test, bench, frequencies, options, plain, J, noise, allowed)


def scaled(bench: Bench, logs: Floats) -> Bench:
    """logs: (factors,) logarithms of FACTORS"""
    for factor, log in zip(FACTORS, logs, strict=True):
        bench = factor.apply(bench, float(np.exp(log)))
    return bench


def bringing_back(changed: Bench, bench: Bench) -> Floats:
    """(factors,) logarithms with which the changed bench's stuck resonances are the bench's: least squares of the
    distances in shares of a half-width and of the logarithms in the deviations that are allowed."""
    wanted, allowed = assembled(bench).stuck_frequencies(2), np.array([f.allowed for f in FACTORS])

    def residual(deviations: Floats) -> Floats:
        apart = assembled(scaled(changed, allowed * deviations)).stuck_frequencies(2) / wanted - 1
        return np.concatenate([apart / (ALIGNED * bench.loss_factor / 2), deviations])

    return allowed * scipy.optimize.least_squares(residual, np.zeros(len(FACTORS)), xtol=1e-6).x


def like(model: Bench, bench: Bench) -> Bench:
    """With Young's modulus such that the stuck in-phase resonance is the bench's."""
    (wanted, *_), (found, *_) = (assembled(b).stuck_frequencies(2) for b in (bench, model))
    return model.tuned(**dict.fromkeys(BODIES, float(wanted / found)))


def covariances(plain: Complex, columns: Floats, test: KindOfTest = EASY) -> tuple[Floats, Floats]:
    """Of the mean over the assemblies. columns: (n, factors) derivatives by the logarithms of FACTORS

    Where no motion was found (nan) nothing is measured: with any variance such points, of which no signature says
    anything, do not count.
    """
    plan, levels = test.plan, test.noise
    forces = np.array([run.force for run in plan.runs])[:, None, None]
    floor = levels.floor / (forces * np.abs(np.exp(plain)))
    size = np.nan_to_num(np.sqrt(levels.relative**2 + levels.force_reading**2 + floor**2), nan=1.0)
    sensors = np.diag(as_real(size + 1j * size) ** 2)
    scatter = columns * np.array([f.scatter(levels) for f in FACTORS])
    channels = np.indices(plain.shape)[1]
    gain = levels.gain * np.stack([as_real((channels == c) + 0j) for c in range(plain.shape[1])], axis=1)
    drift = levels.drift * _of_each_run(plain.shape) * 2 * columns[:, [E_MODULUS]]
    U = np.hstack([scatter, gain, drift])
    noise = (sensors + U @ U.T) / plan.assemblies
    J = columns * np.array([f.allowed for f in FACTORS])
    return noise, noise + J @ J.T


def _of_each_run(shape: tuple[int, ...]) -> Floats:
    """(n, runs) 1 at the values of each run."""
    runs = np.indices(shape)[0]
    return np.stack([as_real((runs == r) * (1 + 1j)) for r in range(shape[0])], axis=1)


def expected(signatures: Mapping[str, Floats], noise: Floats, allowed: Floats) -> dict[str, Expected]:
    """Of each effect; where there are two, of what the other one cannot imitate."""
    found = {}
    for name, signature in signatures.items():
        others = [s for other, s in signatures.items() if other != name]
        wide = allowed + sum((_UNKNOWN * np.outer(s, s) for s in others), np.zeros_like(allowed))
        score, known = (_norm(c, signature) for c in (wide, noise))
        found[name] = Expected(score, score / known if known > 0 else 0.0)
    return found


# Variance of the size of the other effect, in units of its size: as good as unknown.
_UNKNOWN = 1e2


def _norm(covariance: Floats, signature: Floats) -> float:
    factor = scipy.linalg.cho_factor(covariance, lower=True)
    return float(np.sqrt(signature @ scipy.linalg.cho_solve(factor, signature)))


@dataclass(frozen=True)
class Computed:
    case: str
    seconds: float


def compute(case: Case, layout: Layout) -> Computed:
    started = time.perf_counter()
    b = background(case.test, case.laboratory, case.fitted)
    rig = load_rig(b.test.rig)
    signatures = {one.name: b.signature(with_hidden(b.bench, [one], rig)) for one in case.hidden}
    found = expected(signatures, b.noise, b.allowed)
    effects = {name: asdict(one) for name, one in found.items()}
    content = {"case": case.name, "digest": case.digest, "code": code_version(*CODE), "effects": effects}
    write_whole(layout.expected(case.name), content)
    return Computed(case.name, time.perf_counter() - started)


def is_known(case: Case, layout: Layout) -> bool:
    known = read(layout.expected(case.name))
    return known is not None and (known["digest"], known.get("code")) == (case.digest, code_version(*CODE))


def main(
    out: Annotated[Path, typer.Option(help="folder for expected/")] = Layout().folder,
    draw: Draw = None,
    only: Only = None,
    jobs: Annotated[int, typer.Option(min=1, help="processes")] = 1,
) -> None:
    """Expected score and visibility of every case with something hidden."""
    layout = Layout(out)
    wanted = [case for case in chosen_cases(draw, only) if case.hidden and not is_known(case, layout)]
    in_turn(
        partial(compute, layout=layout), wanted, jobs, "expected scores", lambda computed: f"{computed.seconds:.0f} s"
    )


if __name__ == "__main__":
    typer.run(main)
