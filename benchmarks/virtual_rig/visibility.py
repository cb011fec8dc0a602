"""How far each hidden effect moves the resonances: percent of frequency and of the right tip's peak receptance.

    .venv/bin/python benchmarks/virtual_rig/visibility.py [EFFECT ...]

Without noise and scatter, against the same bench with nothing hidden. First: solver settings, which must not
be seen; with EFFECTs named, those alone.
"""

from updamp.parallel.resources import one_thread

one_thread()  # before numpy is loaded: threads make small products many times slower

import sys
from typing import Annotated

import numpy as np
import typer

from updamp.benchmarks.virtual_rig.assembled import assembled
from updamp.benchmarks.virtual_rig.bench import Bench, bench_of
from updamp.benchmarks.virtual_rig.bodies import bodies_of
from updamp.benchmarks.virtual_rig.laboratory import HIDDEN, hidden, quick_sweep, with_hidden
from updamp.benchmarks.virtual_rig.measurement import RIG
from updamp.benchmarks.virtual_rig.periodic import NotSolvedError, SolverOptions
from updamp.benchmarks.virtual_rig.plan import SIX_CURVES, PlannedRun
from updamp.benchmarks.virtual_rig.sensors import loose
from updamp.benchmarks.virtual_rig.stepped_sine import StepMotor
from updamp.model.rig_files import load_rig

USUAL = SolverOptions()
SETTINGS = {
    "harmonics 1-3, 128 samples": SolverOptions(3, 128),
    "harmonics 1-3": SolverOptions(3),
    "harmonics 1-11, 1024 samples": SolverOptions(11, 1024),
}


def peak(bench: Bench, run: PlannedRun, options: SolverOptions = USUAL) -> tuple[float, float, float]:
    """Frequency [Hz] and receptance [m/N] of the right tip at its peak, and of the left tip at its own."""
    rig = assembled(bench)
    resonance, (left, right) = quick_sweep(rig, run)
    motor, points = StepMotor(rig, options), []
    for frequency in np.linspace(resonance + 1.5 * right, resonance - 1.5 * left, 41):
        try:
            motion = motor.step(float(frequency), run.force)
        except NotSolvedError:
            continue
        tips = [motion.response(f"blade_{side}.tip.x")[:1] for side in ("right", "left")]
        points.append((frequency, abs(tips[0][0]) / run.force, abs(loose(tips[1], bench.loose_gain)[0]) / run.force))
    f, right_tip, left_tip = np.array(points).T
    top = int(np.clip(right_tip.argmax(), 1, len(f) - 2))
    a, b, c = np.polyfit(f[top - 1 : top + 2] - f[top], right_tip[top - 1 : top + 2], 2)
    # Where a jump follows the largest value, there is no summit.
    if a >= 0 or abs(b / (2 * a)) > abs(f[top + 1] - f[top - 1]) / 2 or right_tip[top] < right_tip.max():
        top = int(right_tip.argmax())
        return float(f[top]), float(right_tip[top]), float(left_tip.max())
    return float(f[top] - b / (2 * a)), float(c - b**2 / (4 * a)), float(left_tip.max())


def row(name: str, bench: Bench, reference: dict[str, tuple[float, float, float]], options: SolverOptions) -> str:
    cells = []
    for run in SIX_CURVES:
        try:
            frequency, right, left = peak(bench, run, options)
        except NotSolvedError:
            cells.append("not solved")
            continue
        f0, right0, left0 = reference[run.name]
        skew = 100 * (left / right / (left0 / right0) - 1)
        other = f", L/R {skew:+.0f}" if abs(skew) >= 2 else ""
        cells.append(f"{100 * (frequency / f0 - 1):+.2f}, {100 * (right / right0 - 1):+.1f}{other}")
    return " | ".join(["", name, *cells, ""]).strip()


def main(effects: Annotated[list[str] | None, typer.Argument(help="these alone, without the settings")] = None) -> None:
    """Sweep and print a table in Markdown."""
    rig = load_rig(RIG)
    nominal = bench_of(rig, bodies_of(rig, "laboratory"))
    reference = {run.name: peak(nominal, run) for run in SIX_CURVES}
    write = sys.stdout.write
    write("| | " + " | ".join(reference) + " |\n" + "|---" * (len(reference) + 1) + "|\n")
    cells = [f"{f:.2f} Hz, {1e6 * a:.3f} um/N" for f, a, _ in reference.values()]
    write("| nothing hidden | " + " | ".join(cells) + " |\n")
    named = effects or []
    for name, options in () if named else SETTINGS.items():
        write(row(name, nominal, reference, options) + "\n")
    for preset in () if named else ("diagnosis", "diagnosis_contacts"):
        write(row(f"mesh {preset}", bench_of(rig, bodies_of(rig, preset)), reference, USUAL) + "\n")
    for name in named or HIDDEN:
        for strength in HIDDEN[name].strengths:
            write(
                row(f"{name}, {strength}", with_hidden(nominal, [hidden(name, strength)], rig), reference, USUAL) + "\n"
            )
            sys.stdout.flush()


if __name__ == "__main__":
    typer.run(main)
