"""`updamp diagnose` where only frequencies are stated: what could explain them, and what would decide."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from rich.table import Table

from updamp.comparison.findings.stated_values import RESONANCE, WITHOUT_DAMPER
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.stated.low_force_modes import LowForceModes, low_force_modes
from updamp.diagnosis.stated.stated_explanations import Explanation, Explanations, LowForceProblem, explanations
from updamp.diagnosis.stated.stated_predictions import (
    MeasurableQuantity,
    StatedPrediction,
    predict_quantities,
    quantities,
)
from updamp.diagnosis.stated.stated_score import stated_score
from updamp.diagnosis.stated.stated_verdict import survivors_of, verdict_of, why_not_the_cause
from updamp.diagnosis.verdict import Verdict
from updamp.effects.chosen import ChosenEffect, with_effects
from updamp.effects.effect import Effect
from updamp.effects.rig_model import RigModel
from updamp.measurement.measurement import Feature
from updamp.model.small_amplitude import linear_up_to

Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class StatedDiagnosis:
    """left_out: stated values and bounds that belong to forces at which contacts slip, and so were not used"""

    verdict: Verdict
    problem: LowForceProblem
    found: Explanations
    predictions: tuple[StatedPrediction, ...]
    wanted: tuple[MeasurableQuantity, ...]
    left_out: tuple[Feature, ...]


def diagnose_stated(
    model: RigModel,
    windows: Mapping[str, tuple[float, float]],
    component: str,
    features: Sequence[Feature],
    effects: Sequence[Effect],
    rig_effects: Sequence[ChosenEffect] = (),
    provenance: Mapping[str, str] | None = None,
    progress: Progress = lambda _: None,
    criteria: Criteria = Criteria(),
) -> StatedDiagnosis:
    """model: before effects; windows: of the study's modes [Hz]; component: the blade that is excited and looked at

    raises: ValueError where no stated value is a resonance frequency at small force, or of a mode that is not known
    """
    whole = with_effects(model, rig_effects)
    modes = low_force_modes(whole, windows, component)
    used = tuple(f for f in features if _at_small_force(f, whole, modes))
    if not used:
        raise ValueError(
            f"none of the {len(features)} stated features is a resonance_frequency with a value, at a force at which "
            "the model's contacts stick: state one, or measure curves"
        )
    problem = LowForceProblem(model, used, modes, tuple(rig_effects))
    found = explanations(problem, effects, progress)
    by_name = {e.name: e for e in effects}
    scored = {name: stated_score(problem, found.calibrated, by_name[name]) for name in found.helped}
    wanted = quantities(modes)
    progress("next measurement")
    predictions = predict_quantities(survivors_of(found), modes, wanted)
    verdict = verdict_of(problem, found, scored, effects, predictions, wanted, criteria, provenance or {})
    left_out = tuple(f for f in features if f not in used)
    return StatedDiagnosis(verdict, problem, found, predictions, wanted, left_out)


def _at_small_force(feature: Feature, model: RigModel, modes: LowForceModes) -> bool:
    if feature.quantity != RESONANCE or not np.isfinite(feature.value):
        return False
    if WITHOUT_DAMPER in feature.mode:
        return True
    if feature.mode not in modes.windows:
        raise ValueError(f"feature of mode '{feature.mode}': the study has {', '.join(modes.windows)}")
    found, mode = modes.solved(model, (feature.mode,))[feature.mode]
    return not np.isfinite(feature.force) or feature.force < linear_up_to(model, found, mode)


def tables(diagnosis: StatedDiagnosis) -> tuple[Table, ...]:
    """For the terminal: explanations, what the surviving ones would do elsewhere, what to measure next."""
    found = [explanation_table(diagnosis)]
    if diagnosis.predictions:
        found.append(prediction_table(diagnosis))
    if diagnosis.verdict.next_measurement:
        found.append(next_table(diagnosis))
    return tuple(found)


def explanation_table(diagnosis: StatedDiagnosis) -> Table:
    """One line an explanation: parameters, and how far each stated value is off in per cent."""
    found, problem = diagnosis.found, diagnosis.problem
    table = Table(title="What could explain the stated frequencies", title_justify="left", header_style="bold")
    table.add_column("changed", overflow="fold")
    table.add_column("to", overflow="fold")
    for feature in problem.features:
        table.add_column(f"{feature.mode} {feature.value:g} Hz", justify="right")
    table.add_column("met")
    helped = [e for name, e in found.helped.items() if not why_not_the_cause(found, name)]
    pairs = [e for e in found.pairs if e.met]
    for e in (found.as_given, *found.single, found.calibrated, *found.alone.values(), *helped, *pairs):
        off = [f"{100 * (f / s - 1):+.2f} %" for f, s in zip(e.frequencies, problem.stated, strict=True)]
        table.add_row(e.name, changed(e), *off, "yes" if e.met else "no")
    return table


def changed(e: Explanation) -> str:
    """Parameters in words."""
    parts = [f"{name} x {factor:.3g}" for name, factor in e.factors.items()]
    values = e.parametrisation.values(e.u)
    for effect in e.parametrisation.effects:
        parts += [f"{p.name} {values[effect.name][p.name]:.3g} {p.unit}".strip() for p in effect.parameters]
    return ", ".join(parts)


def prediction_table(diagnosis: StatedDiagnosis) -> Table:
    """One line a quantity, one column a surviving explanation."""
    table = Table(title="What they would do elsewhere", title_justify="left", header_style="bold")
    table.add_column("measure", overflow="fold")
    for p in diagnosis.predictions:
        table.add_column(p.survivor.name, justify="right", overflow="fold")
    for i, q in enumerate(diagnosis.wanted):
        table.add_row(
            q.what, *(f"{p.value[i]:.4g} ± {p.deviation[i]:.1g} {q.unit}".strip() for p in diagnosis.predictions)
        )
    return table


def next_table(diagnosis: StatedDiagnosis) -> Table:
    """One line a measurement, most separation per hour first."""
    table = Table(title="What to measure next", title_justify="left", header_style="bold")
    for heading in ("measurement", "separates by", "hours"):
        table.add_column(heading, justify="left" if heading == "measurement" else "right", overflow="fold")
    for m in diagnosis.verdict.next_measurement:
        table.add_row(m.sentence, f"{m.separation:.3g}", f"{m.hours:.2g}")
    return table
