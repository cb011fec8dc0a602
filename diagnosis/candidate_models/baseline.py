"""Where model selection starts: the model without further effects, calibrated to some runs, others held out.

What a finer mesh would change is found for the model without effects. An effect may have a numerical error of its own:
where it lets the contacts at the ends of a face slip early, how many elements there are at the ends decides how early.
So fits that explain most of a misfit pass the numerical gate once more, with the effect in the model
(`with_own_numerics`).
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.compared import compare_at, predict_branches
from updamp.comparison.fit.failing_model import Freedom
from updamp.comparison.fit.fit import Fit, FitOptions, fit
from updamp.comparison.fit.gated_calibration import gated_calibration
from updamp.comparison.fit.numerical_gate import NumericalGate, finer_than
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.odd_readings import odd_readings, without_odd
from updamp.comparison.fit.own_numerics import OwnNumericsOptions, until_it_stays
from updamp.comparison.prediction.branch_tasks import Branches, in_turn
from updamp.comparison.prediction.numerical_error import NumericalError
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.effects.chosen import ChosenEffect
from updamp.effects.rig_model import RigModel
from updamp.model.calibration import nuisances

Floats = NDArray[np.float64]
# Fewest levels of a mode of which one is kept for judging.
_ENOUGH = 3


@dataclass(frozen=True, eq=False)
class Baseline:
    """plan: all runs; training, held_out: places of its conditions

    fitted: to the training runs, with the scatter that the repeats alone show
    repeatability: weighted residual RMS of what differs between the repeats
    given: the model as the rig file has it; finer: those of finer meshes, by name; all without effects
    given_numerics: numerical error of the model as given, where that was asked for
    attempt: how many calibrations were found to be no optimum before (`diagnosis/selection/search.py`)
    own_numerics: whether it has passed the numerical gate where its calibration ends, as fits with effects may have
    """

    plan: Plan
    training: tuple[int, ...]
    held_out: tuple[int, ...]
    fitted: Fit
    repeatability: float
    given: RigModel
    finer: Mapping[str, RigModel] = field(default_factory=dict)
    attempt: int = 0
    own_numerics: bool = False
    given_numerics: NumericalError | None = None

    @property
    def as_given(self) -> tuple[Parametrisation, Floats]:
        """The model before calibration, and (p,) its parameters: what finer numerics change where calibration has led
        to is not what they change as given. With effects in the model that is known of the calibrated one alone."""
        p = self.fitted.parametrisation
        if self.given_numerics is not None and not p.effects:
            p = replace(p, numerics=self.given_numerics)
        return p, p.before_calibration(self.fitted.u)

    @property
    def train_plan(self) -> Plan:
        return self.plan.only(self.training)

    @property
    def held_out_plan(self) -> Plan:
        return self.plan.only(self.held_out)

    @property
    def freedom(self) -> Freedom:
        """Of a misfit of the runs of the fit."""
        return Freedom(self.train_plan.independent, self.plan.noise_freedom)

    @property
    def stated(self) -> int:
        """How many values `farthest_off` looks at."""
        return sum(1 for _ in _stated_values(self.fitted))

    @property
    def unseen_freedom(self) -> Freedom:
        """Of a misfit of the runs that are held out."""
        return Freedom(self.held_out_plan.independent, self.plan.noise_freedom)


def baseline(
    model: RigModel,
    rig_effects: tuple[ChosenEffect, ...],
    plan: Plan,
    finer: Mapping[str, RigModel],
    held_out: Sequence[str] | None = None,
    progress: Callable[[str], None] = lambda _: None,
    branches_of: Branches = in_turn,
) -> Baseline:
    """Numerical gate and calibration.

    held_out: names of runs that no fit sees; by default one level of each mode that was measured at three or more
    branches_of: traces them, in this process or in others
    raises: BranchStoppedError where the model has no response at the beginning of a run; ValueError for a run that
        was not measured
    """
    kept = _held_out(plan, held_out)
    training = tuple(i for i in range(len(plan.conditions)) if i not in kept)
    plain = Parametrisation(model, nuisances(model), rig_effects=rig_effects)
    gate = NumericalGate(plan, finer_than(model, finer), branches_of)
    gated = gated_calibration(plain, gate, training, None, progress)
    found = gated.calibration
    whole = _without_odd_unseen(found.rests_on(plan), kept, found.fit, branches_of)
    if whole.told_by_noise and finer:  # else it is not known how far the model is off along a curve
        whole = replace(whole, common=found.fit.numerics_beside_noise)
    known = gated.given.numerics
    return Baseline(whole, training, kept, found.fit, found.repeatability, model, finer, given_numerics=known)


def _without_odd_unseen(plan: Plan, held_out: Sequence[int], fitted: Fit, branches_of: Branches) -> Plan:
    """The runs that no fit sees without their points that are unlike those next to them."""
    if not held_out:
        return plan
    p, u, unseen = fitted.parametrisation, fitted.u, plan.only(held_out)
    branches = predict_branches(p, u, unseen, None, branches_of)
    return without_odd(plan, odd_readings(compare_at(p, u, unseen, branches, fitted.compared.scatter), unseen))


def _held_out(plan: Plan, names: Sequence[str] | None) -> tuple[int, ...]:
    """Places of the conditions: the second highest level of each mode, unless stated otherwise."""
    if names is not None:
        known = [c.name for c in plan.conditions]
        _check_known("run", names, known)
        return tuple(i for i, name in enumerate(known) if name in names)
    kept: list[int] = []
    for mode in dict.fromkeys(c.mode for c in plan.conditions):
        levels = sorted({c.level for c in plan.conditions if c.mode == mode})
        if len(levels) >= _ENOUGH:
            kept += [i for i, c in enumerate(plan.conditions) if c.mode == mode and c.level == levels[-2]]
    return tuple(sorted(kept))


def farthest_off(fitted: Fit) -> tuple[str, float]:
    """What stands farthest from where it was stated to be, in prior deviations, and by how many: a nuisance parameter,
    or the drift or level of a run, the gain of a sensor or an entry of a mode's shape in one of the assemblies."""
    return max(_stated_values(fitted), key=lambda named: abs(named[1]))


def _stated_values(fitted: Fit) -> Iterator[tuple[str, float]]:
    """Each by name, in prior deviations from where it was stated to be."""
    p, scatter = fitted.parametrisation, fitted.compared.scatter
    for n, u in zip(p.nuisances, fitted.u, strict=False):
        yield n.name, float(u / n.deviation)
    for offsets in fitted.compared.offsets.values():
        yield from offsets.in_deviations(scatter)


def calibrated_as(base: Fit, other: Fit) -> Floats:
    """(p,) parameters of `base`, calibrated as a fit that has effects besides"""
    n, u = len(base.parametrisation.nuisances), base.u.copy()
    u[:n] = other.u[:n]
    return u


def held_out_runs(plan: Plan, runs: Sequence[str] | None, modes: Sequence[str]) -> tuple[str, ...] | None:
    """Names of the runs: those given and all of the modes; None where neither is given, for the usual choice.

    raises: ValueError for a run or a mode that was not measured, and where nothing would be left to fit to
    """
    if not modes and runs is None:
        return None
    _check_known("mode", modes, list(dict.fromkeys(c.mode for c in plan.conditions)))
    _check_known("run", runs or (), [c.name for c in plan.conditions])
    wanted = {*(runs or ()), *(c.name for c in plan.conditions if c.mode in modes)}
    if wanted.issuperset(c.name for c in plan.conditions):
        raise ValueError("all runs are to be held out, and none is left to fit to: hold out fewer")
    return tuple(sorted(wanted))


def _check_known(kind: str, names: Sequence[str], known: Sequence[str]) -> None:
    unknown = [name for name in names if name not in known]
    if unknown:
        raise ValueError(f"no {kind} '{unknown[0]}' to hold out; there are {', '.join(known)}")


def unseen(start: Baseline) -> str:
    """What the held-out error is of, in words."""
    fitted = {c.mode for c in start.train_plan.conditions}
    modes = dict.fromkeys(c.mode for c in start.held_out_plan.conditions)
    if modes and fitted.isdisjoint(modes):
        return f"{' and '.join(modes)}, of which the fit saw no run,"
    return "runs that the fit never saw"


def with_own_numerics(found: Fit, start: Baseline, options: FitOptions) -> Fit:
    """The fit gone on with the numerical error of its own model, asked for where it ends as often as a calibration's
    (`comparison/fit/own_numerics.py`); a model that would still fail is given up."""
    plan, one_of_many = start.train_plan, OwnNumericsOptions(given_up=True)

    def again(last: Fit) -> Fit:
        return with_numerics_of_its_start(last, start, options)

    return until_it_stays(found, again, lambda f: (f, plan), one_of_many)


def with_numerics_of_its_start(found: Fit, start: Baseline, options: FitOptions) -> Fit:
    """The fit gone on with the numerical error of its own model, effects and all, where it stands.

    raises: BranchStoppedError where a finer model has no response at the beginning of a run
    """
    plain = replace(found.parametrisation, numerics=NumericalError())
    gate = NumericalGate(start.plan, finer_than(start.given, start.finer))
    begin = gate.beginning(plain, found.u[: len(plain)], start.training, found.compared.branches)
    return fit(begin.parametrisation, start.train_plan, begin.u, found.compared.scatter, begin.branches, options)
