"""Effects of a joint sized for the rig at hand: what is typical of a beam is out of all proportion for a wire."""

from dataclasses import replace

import numpy as np

from updamp.effects.effect import Effect, EffectParameter
from updamp.effects.rig_model import RigModel

# Of the beam that the catalogue's sizes are stated for: stiffness [N/m], amplitude [m], angular frequency [rad/s].
_BEAM = 5e5, 1e-4, 2 * np.pi * 80.0


def sized(effect: Effect, model: RigModel, amplitude: float) -> Effect:
    """With typical sizes and bounds that are to the model what the catalogue's are to the beam; as it is, where its
    parameters do not say what they grow with or the model is not one of identified modes.

    amplitude: the largest that was measured [m]
    """
    if not model.identified or all(p.grows_with == (0, 0, 0) for p in effect.parameters):
        return effect
    stiffness = _stiffness(model, effect.joint or model.excitation)
    factors = np.array([stiffness, amplitude, float(np.sqrt(model.components.omega_squared.min()))]) / _BEAM
    return replace(effect, parameters=tuple(_scaled(p, factors) for p in effect.parameters))


def _stiffness(model: RigModel, joint: str) -> float:
    """Of the softest mode, as an oscillator that moves as the joint does [N/m]"""
    components = model.components
    share = components.phi[components.row(joint)]
    moving = np.abs(share) > 1e-3 * np.abs(share).max()
    return float(np.min(components.omega_squared[moving] / share[moving] ** 2))


def _scaled(parameter: EffectParameter, factors: np.ndarray) -> EffectParameter:
    factor = float(np.prod(factors ** np.array(parameter.grows_with)))
    return replace(
        parameter,
        lower=parameter.lower * factor,
        upper=parameter.upper * factor,
        typical=parameter.typical * factor,
        null=parameter.null * factor,
    )
