"""A whole measurement: several assemblies, all runs on each, files for the engineer and a sealed one."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from updamp.benchmarks.virtual_rig.bench import Bench, Hidden, bench_of
from updamp.benchmarks.virtual_rig.bodies import bodies_of
from updamp.benchmarks.virtual_rig.files import (
    CSV,
    DESCRIPTION,
    SEALED,
    UFF,
    write_csv,
    write_description,
    write_sealed,
    write_uff,
)
from updamp.benchmarks.virtual_rig.laboratory import AssemblyDraw, RunRecord, draw_assembly, measured, put_together
from updamp.benchmarks.virtual_rig.periodic import SolverOptions
from updamp.benchmarks.virtual_rig.plan import NoiseLevels, TestPlan
from updamp.benchmarks.virtual_rig.sensors import Recorded
from updamp.model.rig_files import load_rig
from updamp.rig.rig import Rig

RIG = Path(__file__).parents[2] / "rigs" / "virtual_rig.toml"


@dataclass(frozen=True, eq=False)
class _Campaign:
    """All runs on all assemblies. nominal: the bench with nothing hidden and no scatter"""

    nominal: Bench
    rig: Rig
    plan: TestPlan
    hidden: tuple[Hidden, ...]
    noise: NoiseLevels
    options: SolverOptions

    def made(
        self, rng: np.random.Generator, progress: Callable[[str], None]
    ) -> tuple[list[AssemblyDraw], list[Recorded], list[RunRecord]]:
        plan, noise = self.plan, self.noise
        drift, draws, sweeps, records = 0.0, [], [], []
        for repeat in range(1, plan.assemblies + 1):
            draw = draw_assembly(rng, noise, plan.channels)
            draws.append(draw)
            bench = put_together(self.nominal, draw, self.hidden, self.rig)
            for run in plan.runs:
                progress(f"assembly {repeat}, {run.name}")
                step = noise.drift * rng.standard_normal()
                path = (drift, drift + noise.ramp * step)
                drift += step
                there = bench.in_run(plan.place(run))
                sweep, record = measured(there, run, repeat, path, draw, plan, noise, rng, self.options)
                sweeps.append(sweep)
                records.append(record)
        return draws, sweeps, records


def make_measurement(
    out: Path,
    plan: TestPlan = TestPlan(),
    hidden: Sequence[Hidden] = (),
    seed: int = 0,
    noise: NoiseLevels = NoiseLevels(),
    rig: Rig | None = None,
    preset: str = "laboratory",
    options: SolverOptions = SolverOptions(),
    progress: Callable[[str], None] = lambda _: None,
    sealed: Path | None = None,
) -> None:
    """Write measurement.toml, sweeps.csv (and sweeps.uff) and sealed.json into a folder, which is made.

    The same arguments give the same files. rig: that of rigs/virtual_rig.toml by default; preset: the laboratory's mesh
    options: of its solver; progress: is told which run begins; sealed: file for the truth, out/sealed.json by default

    raises: ValueError where the plan names a mode that is neither IP nor OOP
    """
    if wrong := {run.mode for run in plan.runs} - {"IP", "OOP"}:
        raise ValueError(f"TestPlan.runs: mode {', '.join(sorted(wrong))}: the laboratory measures IP and OOP")
    rig = load_rig(RIG) if rig is None else rig
    campaign = _Campaign(bench_of(rig, bodies_of(rig, preset)), rig, plan, tuple(hidden), noise, options)
    draws, sweeps, records = campaign.made(np.random.default_rng(seed), progress)
    out.mkdir(parents=True, exist_ok=True)
    write_csv(out / CSV, sweeps, plan.harmonics)
    if plan.uff:
        write_uff(out / UFF, sweeps, plan.harmonics)
    write_description(out / DESCRIPTION, rig, plan, CSV)
    write_sealed(
        out / SEALED if sealed is None else sealed,
        {
            "hidden": [asdict(one) for one in hidden], "seed": seed, "rig": rig.name, "preset": preset,
            "plan": asdict(plan), "noise": asdict(noise), "solver": asdict(options),
            "assemblies": [asdict(draw) for draw in draws], "runs": [asdict(record) for record in records],
        },
    )  # fmt: skip
