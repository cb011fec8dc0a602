"""What an error of an identified mode's shape does to what is observed.

The shape of a mode that was identified in a test is known to about a hundredth of its largest displacement. Near a node
that is a large part of what is there, of that mode alone: no gain of the sensor makes up for it.
"""

from dataclasses import replace

import numpy as np

from updamp.comparison.fit.observations import Observations, Plan
from updamp.comparison.fit.scatter import Scatter
from updamp.comparison.fit.shape_error import ShapeError
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.effects.rig_model import RigModel

# Of the largest displacement: what is smaller counts as much, so that an error of the usual size doubles it.
_LEAST = Scatter.shape


def with_shapes(plan: Plan, model: RigModel, calibrated: bool) -> Plan:
    """The same plan for a rig given by several modes; of a single one a shape is the sensors' gains.

    calibrated: whether responses and forces are in units that the model's can be held against
    """
    if not model.identified or len(model.modes) < 2:
        return plan
    runs = (replace(o, shapes=_shapes(o, plan.conditions[o.test], model, calibrated)) for o in plan.observations)
    return replace(plan, observations=tuple(runs))


def _shapes(run: Observations, condition: RunCondition, model: RigModel, calibrated: bool) -> tuple[ShapeError, ...]:
    """Of each sensor: the mode's part is what was measured less the other modes' linear response."""
    free, mode = model.components, _mode_of(condition, model)
    entries = free.phi[:, mode] / np.abs(free.phi[:, mode]).max()
    drive = free.phi[free.row(model.excitation)]
    others = np.array([np.linalg.solve(free.modal_dynamic_stiffness(2 * np.pi * f), drive) for f in run.frequency])
    others[:, mode] = 0.0
    force, found = condition.force * np.exp(run.log_force), []
    for j, row in enumerate(free.row(point) for point, _ in condition.sensors):
        share = np.ones(len(run), dtype=complex)
        if calibrated and run.has_phase(j):
            share -= (
                force * (others @ free.phi[row]) / np.exp(run.observed[:, 1 + 2 * j] + 1j * run.observed[:, 2 + 2 * j])
            )
        found.append(ShapeError(float(np.copysign(max(abs(entries[row]), _LEAST), entries[row])), share))
    return tuple(found)


def _mode_of(condition: RunCondition, model: RigModel) -> int:
    """By its name, or the nearest to the middle of the window."""
    if condition.mode in model.modes:
        return model.modes.index(condition.mode)
    middle = float(np.sqrt(np.prod(condition.window)))
    return int(np.argmin(np.abs(np.log(model.components.frequencies / middle))))
