"""An effect of a joint at another point than the excitation: "joint_cubic@arm.tip.x".

A model of several modes tells where a joint is: each mode moves it otherwise.
"""

from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from updamp.effects.catalogue import JOINTS, catalogue
from updamp.effects.effect import AT, Effect, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import model_with

Floats = NDArray[np.float64]
# Sine of the angle between the motions of two points in all modes, below which they tell the same of a joint: shapes
# that were identified in a test are hardly known any better.
_ALIKE = 0.05


def placed(effect: Effect, point: str) -> Effect:
    """The effect with its joint at a point of the model."""
    return replace(
        effect,
        name=f"{effect.name}{AT}{point}",
        sentence=f"{effect.sentence}, at {point}",
        apply=partial(_apply_at, effect, point),
        joint=point,
    )


def _apply_at(effect: Effect, point: str, model: RigModel, values: Values) -> RigModel:
    there = effect.apply(replace(model_with(model, (point,)), joint=point), values)
    return replace(there, joint=model.joint)


def effect_called(name: str) -> Effect | None:
    """Of the catalogue, as it is or placed at a point; None where there is none. raises: as `catalogue`"""
    kind, _, point = name.partition(AT)
    return placed(JOINTS[kind], point) if kind in JOINTS and point else catalogue().get(name)


def other_places(model: RigModel, measured: Collection[str]) -> tuple[str, ...]:
    """Points where a joint would be seen otherwise than at the excitation, and than at each other: none where a single
    mode was measured, since a joint that moves otherwise there has other parameters and the same response.

    measured: names of modes
    """
    if not model.identified:
        return ()
    modes = [i for i, name in enumerate(model.modes) if name in measured]
    found, told = [], [_direction(model, model.excitation, modes)]
    for point in model.components.points:
        direction = _direction(model, point, modes)
        if np.any(direction) and all(_differ(direction, one) for one in told):
            told.append(direction)
            found.append(point)
    return tuple(found)


def _direction(model: RigModel, point: str, modes: Sequence[int]) -> Floats:
    """(m,) of its motion in the modes, of unit length; nil where it does not move"""
    share = model.components.phi[model.components.row(point)][modes]
    return share / (np.linalg.norm(share) or 1.0)


def _differ(one: Floats, other: Floats) -> bool:
    return bool(1 - (one @ other) ** 2 > _ALIKE**2)


def at_other_places(effects: Sequence[Effect], model: RigModel, measured: Collection[str]) -> tuple[Effect, ...]:
    """Those of a joint among them, at each of `other_places`."""
    places = other_places(model, measured)
    return tuple(placed(effect, point) for effect in effects if effect.name in JOINTS for point in places)
