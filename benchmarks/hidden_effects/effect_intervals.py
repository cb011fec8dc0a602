"""Intervals of what is hidden, fitted alone from its true size: what is wrong with them then is not the search.

.venv/bin/python benchmarks/hidden_effects/effect_intervals.py --draw N [--folder FOLDER] [--only case_012] [--own 3]

First with the numerical error of the model without effects, then with that of the model itself, asked for again and
again where the fit ends. A few minutes a case, once its rig is built.
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
from updamp.diagnosis.candidate_models.baseline import Baseline, baseline, with_numerics_of_its_start
from updamp.diagnosis.candidate_models.intervals import intervals
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
    """One parameter in one fit. numerics: whose numerical error; seconds: of a core"""

    case: str
    parameter: str
    numerics: str
    misfit: float
    value: float
    lower: float
    upper: float
    true: float
    seconds: float

    @property
    def text(self) -> str:
        holds = "" if self.lower <= self.true <= self.upper else " **no**"
        return (
            f"| {self.case} | {self.parameter} | {self.numerics} | {self.misfit:.3f} | {self.value:.4g} "
            f"| {self.lower:.4g} to {self.upper:.4g}{holds} | {self.true:.4g} | {self.seconds:.0f} |"
        )


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
        values = fitted.parametrisation.values(fitted.u)
        for e in effects:
            for q, (lower, upper) in zip(e.parameters, intervals(fitted, e), strict=True):
                value, true = values[e.name][q.name], parameters[e.name][q.name]
                misfit = fitted.compared.mean_squared_misfit
                yield Line(task.name, f"{e.name}.{q.name}", numerics, misfit, value, lower, upper, true, seconds)


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
    typer.echo("| case | parameter | numerical error | misfit | value | 95 % interval | true | s |")
    typer.echo("|" + 8 * "---|")
    for task in found:
        truth = read(layout.truth(task.name))
        if truth is not None and in_catalogue(truth):
            for line in lines(task, truth, folder / FOLDER / task.name, own):
                typer.echo(line.text)


if __name__ == "__main__":
    typer.run(main)
