"""Intervals of what is hidden, fitted alone from its true size: what is wrong with them then is not the search.

.venv/bin/python benchmarks/hidden_effects/effect_intervals.py --draw N [--folder FOLDER] [--only case_012] [--own 3]

First with the numerical error of the model without effects, then with that of the model itself, asked for again and
again where the fit ends. Intervals from derivatives where it ends, and by profile likelihood. A few minutes a case,
once its rig is built.
"""

from updamp.parallel.resources import one_thread

one_thread()  # before numpy is loaded: threads make small products many times slower

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console

from updamp.benchmarks.hidden_effects.fitted_model import FINER, place
from updamp.benchmarks.hidden_effects.layout import Layout, read
from updamp.benchmarks.hidden_effects.run import Task, build_models, tasks
from updamp.benchmarks.hidden_effects.version_2 import Draw, Only, chosen_cases
from updamp.benchmarks.virtual_rig.laboratory import HIDDEN
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.observations import plan_of
from updamp.comparison.fit.profile_likelihood import profile
from updamp.diagnosis.candidate_models.baseline import Baseline, baseline, with_numerics_of_its_start
from updamp.diagnosis.candidate_models.intervals import in_units, intervals
from updamp.diagnosis.candidate_models.refit import FULL, Starts, refit
from updamp.diagnosis.criteria import Criteria
from updamp.effects.catalogue import CATALOGUE
from updamp.effects.effect import Effect
from updamp.effects.sized import sized
from updamp.hbm.compilation_cache import keep_compiled
from updamp.workflow.built_rig import chosen_dimensions
from updamp.workflow.comparison_inputs import CompareFiles, comparison_inputs
from updamp.workflow.progress import Display

Truth = Mapping[str, Mapping[str, float]]
FOLDER = "intervals"


@dataclass(frozen=True)
class Line:
    """One parameter in one fit. numerics: whose numerical error; linear, profile: its intervals; seconds: of a core,
    for the fit and for the profile"""

    case: str
    parameter: str
    numerics: str
    misfit: float
    value: float
    linear: tuple[float, float]
    profile: tuple[float, float]
    true: float
    seconds: tuple[float, float]

    @property
    def text(self) -> str:
        fit, profile = self.seconds
        return (
            f"| {self.case} | {self.parameter} | {self.numerics} | {self.misfit:.3f} | {self.value:.4g} "
            f"| {self._of(self.linear)} | {self._of(self.profile)} | {self.true:.4g} | {fit:.0f} + {profile:.0f} |"
        )

    def _of(self, interval: tuple[float, float]) -> str:
        lower, upper = interval
        return f"{lower:.4g} to {upper:.4g}{'' if lower <= self.true <= upper else ' **no**'}"


def start_of(task: Task, folder: Path) -> Baseline:
    """The model without effects, calibrated. folder: for the rig's files"""
    place(task.model, folder, FINER[task.preset])
    files = CompareFiles(task.rig, task.measurement, folder)
    with Display(Console(quiet=True)) as display:
        inputs = comparison_inputs(files, task.preset, 1, display, FINER[task.preset], chosen_dimensions(None))
    return baseline(inputs.before_effects, inputs.rig_effects, plan_of(inputs.measurement), inputs.finer)


def fits(start: Baseline, effects: Sequence[Effect], truth: Truth, own: int) -> Iterator[tuple[str, Fit, float]]:
    """Whose numerical error, the fit with it, and processor time [s]; none where there is no response."""
    size = [(truth[e.name][q.name] - q.null) / (q.typical - q.null) for e in effects for q in e.parameters]
    started = time.process_time()
    found = refit(start.fitted, start.train_plan, effects, Starts((), (np.array(size),)), Criteria(), full=True)
    if found is None:
        return
    fitted = found.fitted
    yield "without", fitted, time.process_time() - started
    for i in range(own):
        started = time.process_time()
        fitted = with_numerics_of_its_start(fitted, start, FULL)
        yield f"own, {i + 1}", fitted, time.process_time() - started


def lines(task: Task, truth: Mapping[str, Any], folder: Path, own: int) -> Iterator[Line]:
    start, parameters = start_of(task, folder), truth["parameters"]
    named = [CATALOGUE[HIDDEN[name].catalogue_name] for name in truth["effects"]]
    effects = [sized(e, start.fitted.parametrisation.base, start.plan.largest_amplitude) for e in named]
    for numerics, fitted, seconds in fits(start, effects, parameters, own):
        p, misfit = fitted.parametrisation, fitted.compared.mean_squared_misfit
        for e in effects:
            first, linear = p.columns(e.name).start, intervals(fitted, e)
            for i, q in enumerate(e.parameters):
                started = time.process_time()
                by_profile = in_units(q, profile(fitted, start.train_plan, first + i).interval)
                name, taken = f"{e.name}.{q.name}", (seconds, time.process_time() - started)
                value, true = p.values(fitted.u)[e.name][q.name], parameters[e.name][q.name]
                yield Line(task.name, name, numerics, misfit, value, linear[i], by_profile, true, taken)


def in_catalogue(truth: Mapping[str, Any]) -> bool:
    """Whether something is hidden, and all of it can be fitted with its true values."""
    names = [HIDDEN[name].catalogue_name for name in truth["effects"]]
    return bool(names) and all(name in truth["parameters"] for name in names)


def main(
    folder: Annotated[Path, typer.Option(help="with data/ and truth/; intervals/ goes there")] = Layout().folder,
    only: Only = None,
    draw: Draw = None,
    own: Annotated[int, typer.Option(min=0, help="how often the model's own numerical error is asked for")] = 3,
) -> None:
    """Fit what is hidden in each case that has data, from its true size, and see whether intervals hold it."""
    keep_compiled()
    layout = Layout(folder)
    found, _ = tasks(layout, chosen_cases(draw, only))
    build_models(layout, found)
    typer.echo("| case | parameter | numerical error | misfit | value | 95 % interval | by profile | true | s |")
    typer.echo("|" + 9 * "---|")
    for task in found:
        truth = read(layout.truth(task.name))
        if truth is not None and in_catalogue(truth):
            for line in lines(task, truth, folder / FOLDER / task.name, own):
                typer.echo(line.text)


if __name__ == "__main__":
    typer.run(main)
