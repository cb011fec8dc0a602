"""An effect of the user's own, tried on the model before hours are spent on it."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from updamp.effects.effect import Effect
from updamp.effects.rig_model import RigModel
from updamp.effects.user_effect import OwnCodeError, in_words, place_of
from updamp.hbm.problem.elements import ElementGroup, departures
from updamp.hbm.problem.own_law_checks import OwnLawError

Floats = NDArray[np.float64]

# Motions at which the force of its elements is computed [m]: at rest, where solving begins, and amplitudes that blades
# and contacts reach.
_MOTIONS = (0.0, 1e-6, 1e-4)


def refuse_unusable(effect: Effect, path: Path, model: RigModel) -> None:
    """Where the model has no place for the effect that is said elsewhere.

    raises: OwnCodeError naming the effect and the file where the effect cannot be applied at its typical values, or the
        force of what it adds to the model cannot be computed or is not finite
    """
    path, before = path.resolve(), {group.law for group in model.groups}
    try:
        changed = effect.apply(model, effect.at_typical())
        added = [group for group in changed.groups if group.law not in before]
    except (OwnLawError, TypeError) as error:  # the latter of a law that is no frozen dataclass, a hash
        raise OwnCodeError(f'{path}: what the effect "{effect.name}" adds cannot be used: {in_words(error)}') from error
    except (ValueError, KeyError):
        return
    w = float(np.sqrt(np.max(model.components.omega_squared)))
    for group in added:
        _refuse_force(effect, path, group, changed, w)


def _refuse_force(effect: Effect, path: Path, group: ElementGroup, model: RigModel, w: float) -> None:
    law = type(group.law).__name__
    for size in _MOTIONS:
        x = np.zeros((*group.rows.shape, model.harmonics.n_coefficients))
        x[..., model.harmonics.slices[1].start] = size
        try:
            found = departures(group, x, w, model.harmonics, model.time_samples)
        except Exception as error:
            raise OwnCodeError(
                f'{place_of(error, path)}: the force of {law}, of the effect "{effect.name}", cannot be computed: '
                f"{in_words(error)}"
            ) from error
        if not (np.isfinite(found.force).all() and np.isfinite(found.tangent).all()):
            what = "force" if not np.isfinite(found.force).all() else "derivative of the force"
            raise OwnCodeError(
                f'{path}: {what} of {law}, of the effect "{effect.name}", is not finite at a motion of {size:g} m: '
                "look for a division by zero, a logarithm or a root of what may vanish (jax.numpy.where takes the "
                "derivatives of both of its branches)"
            )
