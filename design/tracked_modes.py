"""The study's modes in a changed rig: which stuck mode each of them has become, and where its window lies now.

A mode is recognised by its shape at the blades' named points (modal assurance criterion, Ewins 2000, ch. 5) and, where
shapes are alike, by its frequency. The window moves with the mode, its width in proportion.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.effects.rig_model import RigModel
from updamp.hbm.problem.linear_model import LinearModel

Window = tuple[float, float]
Floats = NDArray[np.float64]

_FURTHEST = 2.0  # ratio of frequencies
_LEAST_LIKENESS = 0.5


class UnknownResponseError(ValueError):
    """A response that a design does not have, with the reason: a solver that stopped, a mode that is not there."""


@dataclass(frozen=True)
class ModeReference:
    """A mode of the rig as its file stands. window, frequency: of the stuck mode [Hz]; shape: point -> [kg^-1/2]"""

    name: str
    window: Window
    frequency: float
    shape: Mapping[str, float]


@dataclass(frozen=True)
class TrackedMode:
    """frequency: of the stuck mode [Hz]; window: [Hz]; likeness: of the shapes, 0 to 1"""

    frequency: float
    window: Window
    likeness: float


def mode_references(model: RigModel, windows: Mapping[str, Window], observed: str) -> tuple[ModeReference, ...]:
    """The stuck mode in each window that answers most to the excitation.

    observed: name of the point where responses are taken
    raises: ValueError naming a window without a stuck mode
    """
    stuck, points = model.system.stuck, _points(model)
    rows = [stuck.row(point) for point in points]
    answer = np.abs(stuck.phi[stuck.row(observed)] * stuck.phi[stuck.row(model.excitation)])
    found = []
    for name, (low, high) in windows.items():
        inside = np.flatnonzero((stuck.frequencies >= low) & (stuck.frequencies <= high))
        if not len(inside):
            near = ", ".join(f"{f:.4g}" for f in stuck.frequencies[:6])
            raise ValueError(
                f"study.modes.{name}.window: no stuck mode between {low:g} and {high:g} Hz; the lowest are {near} Hz"
            )
        mode = int(inside[np.argmax(answer[inside])])
        shape = dict(zip(points, stuck.phi[rows, mode].tolist(), strict=True))
        found.append(ModeReference(name, (low, high), float(stuck.frequencies[mode]), shape))
    return tuple(found)


def tracked_mode(stuck: LinearModel, reference: ModeReference) -> TrackedMode:
    """raises: UnknownResponseError where no stuck mode is like the reference"""
    shape = np.array(list(reference.shape.values()))
    shapes = stuck.phi[[stuck.row(point) for point in reference.shape]]
    near = _apart(stuck.frequencies, reference.frequency) < math.log(_FURTHEST)
    likeness = np.where(near, modal_assurance(shape, shapes), 0.0)
    best = int(np.argmax(tracking_score(likeness, stuck.frequencies, reference.frequency)))
    if likeness[best] < _LEAST_LIKENESS:
        raise UnknownResponseError(
            f"mode {reference.name}: no stuck mode within a factor of {_FURTHEST:g} of {reference.frequency:.4g} Hz is "
            f"like it (best likeness {likeness[best]:.2f}); narrow the bounds of the variables"
        )
    frequency = float(stuck.frequencies[best])
    low, high = (edge * frequency / reference.frequency for edge in reference.window)
    return TrackedMode(frequency, (low, high), float(likeness[best]))


def modal_assurance(shape: Floats, shapes: NDArray[Any]) -> Floats:
    """(n,) modal assurance criterion of each column of `shapes`, real or complex, with `shape`: 0 to 1"""
    sizes = (shape @ shape) * np.sum(np.abs(shapes) ** 2, axis=0)
    return np.asarray(np.abs(shape @ shapes) ** 2 / np.maximum(sizes, np.finfo(float).tiny))


def tracking_score(likeness: Floats, frequencies: Floats, near: float) -> Floats:
    """(n,) by which a mode is recognised: how alike its shape is, the less the further its frequency is from `near`."""
    return likeness * np.exp(-_apart(frequencies, near))


def _apart(frequencies: Floats, near: float) -> Floats:
    """Logarithm of the ratio, its size"""
    return np.asarray(np.abs(np.log(np.maximum(frequencies, 1e-9) / near)))


def _points(model: RigModel) -> tuple[str, ...]:
    """Of what vibrates for its own sake: the damper's place among the blades changes from design to design."""
    return tuple(point for point in model.components.points if not point.startswith("damper."))
