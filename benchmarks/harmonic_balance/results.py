"""What was measured, as the file bench.json and as tables."""

import json
import os
import platform
import subprocess
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from updamp.benchmarks.harmonic_balance.growth import Growth
from updamp.benchmarks.harmonic_balance.measure import Cost
from updamp.benchmarks.harmonic_balance.peers_problem import MODEL, PEERS, THREADS, Costs
from updamp.benchmarks.harmonic_balance.rig_curves import AllCurves, CurveCost

PACKAGES = ("updamp", "numpy", "scipy", "jax", "jaxlib")


@dataclass(frozen=True, eq=False)
class Results:
    """None where it was not measured: `rig` and `ten` want a run's folder, `stress` and `sensitivities` their files."""

    problem: Costs
    rig: CurveCost | None
    ten: AllCurves | None
    grown: Growth
    stress: dict[str, Any] | None
    sensitivities: dict[str, Any] | None = None

    def as_json(self) -> dict[str, Any]:
        rig = asdict(self.rig) if self.rig is not None else {"point_s": None}
        return {
            "commit": commit_of_code(),
            **{name: _by_quantity(costs) for name, costs in self.problem.items()},
            "reference_rig": {
                **rig,
                "ten_curves_s": self.ten.seconds if self.ten is not None else None,
                "ten_curves": asdict(self.ten) if self.ten is not None else None,
            },
            "stress": self.stress or {"within_pull": None, "beyond_pull": None},
            "sensitivities": self.sensitivities or {"share_of_point": None},
            "growth": asdict(self.grown),
            "peers": {name: {"evaluation_s": e, "point_s": p} for name, (e, p) in PEERS.items()},
            "machine": {"processor": _processor(), "cores": os.cpu_count(), "load_average": os.getloadavg()},
            "versions": {"python": platform.python_version(), **{name: version(name) for name in PACKAGES}},
        }

    def write(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(self.as_json(), indent=1) + "\n", encoding="utf-8")

    def show(self, console: Console) -> None:
        for sentence in self._missing():
            console.print(f"[yellow]not measured[/]  {sentence}", soft_wrap=True)
        console.print(_problem_table(self.problem))
        if self.rig is not None:
            console.print(_rig_table(self.rig, self.ten))
        console.print(_growth_table(self.grown))
        if self.stress is not None:
            for name in ("within_pull", "beyond_pull"):
                n = self.stress[name]
                console.print(
                    f"stress grid, force {name.replace('_', ' the ')}: {n['complete']} of {n['curves']} curves "
                    f"complete, {n['false_peaks']} false peaks"
                )

    def _missing(self) -> Iterable[str]:
        if all(cost is None for costs in self.problem.values() for cost in costs.values()):
            yield f"{MODEL}: the solved problems (shared/reference/hbm) are not beside the checkout"
        if self.rig is not None and self.ten is None:
            yield "the ten curves: left out (--no-ten)"
        if self.rig is None:
            yield "the rig: no stages of a run were found; make them with `make run`, or name a run with --run"
        if self.stress is None:
            yield "the stress grid: results/stress.json is not there; benchmarks/stress.py makes it"
        yield pyharm_sentence()


def commit_of_code() -> str | None:
    """State of the code that was measured, None outside a checkout; "+" where files were changed since."""
    root = Path(__file__).parents[2]
    try:
        asked = ["describe", "--always", "--abbrev=40", "--dirty=+", "--exclude=*"]
        found = subprocess.run(["git", "-C", str(root), *asked], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return found.stdout.strip()


def pyharm_sentence() -> str:
    if find_spec("pyHarm") is None:
        return "pyHarm-os: not installed; the figures are those measured before"
    return "pyHarm-os: installed, but the problem is not set up for it here; the figures are those measured before"


def _by_quantity(costs: dict[str, Cost | None]) -> dict[str, dict[str, Any]]:
    """quantity -> threads -> value, from threads -> Cost"""
    names = Cost.__dataclass_fields__
    return {name: {t: getattr(c, name) if c is not None else None for t, c in costs.items()} for name in names}


def _problem_table(problem: Costs) -> Table:
    table = Table(title="146 contacts, 50 modes, no residual flexibility, 40 N: median processor time (wall time)")
    for column in ("", "threads", "residual with Jacobian", "point", "Newton", "Krylov", "points", "times tmdsimpy"):
        table.add_column(column, justify="left" if not column else "right")
    for name, costs in problem.items():
        for threads, c in costs.items():
            if c is None:
                continue
            table.add_row(
                name, str(THREADS[threads]), _pair(c.evaluation_s, c.evaluation_wall_s),
                _pair(c.point_s, c.point_wall_s), f"{c.newton_median:g}", f"{c.krylov_mean:.0f}",
                f"{c.points} {c.stopped}", f"{2.0 / c.point_s:.0f}",
            )  # fmt: skip
    table.add_section()
    for name, (evaluation, point) in PEERS.items():
        table.add_row(name, "1", f"{evaluation:g} s", f"{point:g} s" if point is not None else "", "", "", "", "")
    return table


def _rig_table(rig: CurveCost, ten: AllCurves | None) -> Table:
    table = Table("", "seconds", "", title=f"the rig with residual flexibility, {rig.unknowns} unknowns")
    table.add_row(
        f"point of {rig.mode} {rig.force_N:g} N, median", _pair(rig.point_s, rig.point_wall_s),
        f"{rig.points} points, Newton {rig.newton_median:g}, Krylov {rig.krylov_mean:.0f}, "
        f"evaluations {rig.evaluations_mean:.1f} a point {rig.stopped}",
    )  # fmt: skip
    if ten is not None:
        table.add_row(f"all {len(ten.curves)} curves, {ten.workers} workers (wall)", f"{ten.seconds:.0f} s", "")
        for name, curve in ten.curves.items():
            account = f"{curve['points']} points, {curve['gaps']} gaps {curve['problem']}"
            table.add_row(f"  {name}", f"{curve['seconds']:.0f} s", account)
    return table


def _growth_table(grown: Growth) -> Table:
    columns = (
        "contacts",
        "harmonics",
        "unknowns",
        "residual with Jacobian",
        "point",
        "Newton",
        "Krylov",
        "active rows",
    )
    table = Table(*columns, title="synthetic structure, one thread: median processor time (wall time)")
    rows = [(str(n), "0-3", c) for n, c in grown.contacts.items()]
    rows += [("146", f"0-{h}", c) for h, c in grown.harmonics.items()]
    for contacts, harmonics, c in rows:
        table.add_row(
            contacts, harmonics, str(c.unknowns), _pair(c.evaluation_s, c.evaluation_wall_s),
            _pair(c.point_s, c.point_wall_s), f"{c.newton_median:g}", f"{c.krylov_mean:.0f}", str(c.active_rows),
        )  # fmt: skip
    return table


def _pair(processor: float, wall: float) -> str:
    return f"{processor:.4f} ({wall:.4f}) s"


def _processor() -> str:
    """The model's name where the system tells it."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text(encoding="utf-8").splitlines() if cpuinfo.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()
