"""A rig built once more with another dimension, and the way from the model to that one and beyond.

Finite elements give the model at two values of a dimension, on meshes of the same topology, and their modes are laid
side by side (`mode_alignment.py`). What is positive grows by the same factor for each step that multiplies the
dimension by one: contact stiffness, preload, and modal stiffness, as K(t) = K^1/2 exp(t L) K^1/2, where exp(L) is the
other stiffness in units of the first (the geodesic of positive definite matrices: Bhatia, Positive Definite Matrices,
2007). So powers of the dimension are met exactly, as the stiffness of a beam goes with the square of its thickness.
The flexibility at rest is B B', of which B is blended, as mode shapes are where a face turns. Residual flexibility is
what the modes leave of it: where they mix on the way, what is wrong with their shapes is made up for at low
frequencies, and what a mesh changes of them too (`on_finer_mesh`). Mode shapes and gaps are linear in the steps. All is
exact at both ends, and off by the square of the change elsewhere.

Factors that a calibration has put on the model before act on what the dimension changes too.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import jax.numpy as jnp
import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.effects.contact_faces import entry
from updamp.effects.mode_alignment import alignment
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import function_of, with_modal_stiffness
from updamp.effects.varied_dimension import VariedDimension
from updamp.hbm.problem.structural_changes import Attachment

Floats = NDArray[np.float64]
_GROWING, _SHIFTED = ("kt", "kn", "n0"), ("n0", "gap")


def varied_dimension(built: RigModel, varied: RigModel, step: float) -> VariedDimension:
    """built, varied: before calibration and effects, with the same contact elements; step: relative change of the
    dimension

    raises: ModesDifferError where the step is too long for modes to be told
    """
    before, after = built.components, varied.components
    Q = alignment(before, after, built.owner)
    rigid = before.omega_squared <= 0
    unit = np.where(rigid, 0.0, 1 / np.sqrt(np.where(rigid, 1.0, before.omega_squared)))
    relative = unit[:, None] * (Q.T * after.omega_squared @ Q) * unit + np.diag(rigid.astype(float))
    old, new = ({name: entry(model, name) for name in {*_GROWING, *_SHIFTED}} for model in (built, varied))
    ratio = {name: (old[name] > 0) & (new[name] > 0) for name in _GROWING}
    others = {a.name: a.points for a in varied.attachments}
    root, there = _roots(before.flexibility_at_rest, after.flexibility_at_rest)
    return VariedDimension(
        step=step,
        built=before,
        stiffening=function_of(np.log, relative),
        phi=after.phi @ Q - before.phi,
        root=root,
        widening=there - root,
        softening=float(np.log(np.linalg.norm(there) / np.linalg.norm(root))),
        growth={n: np.log(np.where(ratio[n], new[n], 1.0) / np.where(ratio[n], old[n], 1.0)) for n in _GROWING},
        shift={n: np.where(ratio.get(n, False), 0.0, new[n] - old[n]) for n in _SHIFTED},
        weights={a.name: {p: others[a.name][p] - w for p, w in a.points.items()} for a in built.attachments},
    )


def _roots(before: Floats, after: Floats) -> tuple[Floats, Floats]:
    """B of B B', the two that are nearest to each other. before, after: (n, n), positive semidefinite"""
    one, other = (function_of(lambda values: np.sqrt(np.maximum(values, 0.0)), each) for each in (before, after))
    return one, np.asarray(other @ scipy.linalg.orthogonal_procrustes(other, one)[0])


def on_finer_mesh(varied: VariedDimension, finer: RigModel) -> VariedDimension:
    """The same for a finer mesh with the same contact elements. What the mesh changes of the change is left out: as
    small beside it as the mesh's error beside the model.

    finer: before calibration and effects; raises: ModesDifferError where it has other modes
    """
    Q = alignment(varied.built, finer.components, finer.owner)
    stiffening = Q @ varied.stiffening @ Q.T
    return replace(varied, built=finer.components, stiffening=stiffening, phi=varied.phi @ Q.T)


def blended(model: RigModel, varied: VariedDimension, change: float) -> RigModel:
    """The model with the dimension changed by so much, relative; the model itself for none.

    raises: ValueError where it has no contacts, or its modes are not those it was built with, rotated
    """
    if change == 0:
        return model
    t = varied.steps(change)
    values = {name: entry(model, name) * np.exp(t * growth) for name, growth in varied.growth.items()}
    for name, shift in varied.shift.items():
        values[name] = values.get(name, entry(model, name)) + t * shift
    values["n0"] = np.maximum(values["n0"], 0.0)
    entries: dict[str, Any] = {name: jnp.asarray(value) for name, value in values.items()}
    moved = tuple(_moved(a, varied.weights.get(a.name, {}), t) for a in model.attachments)
    return _structure(replace(model, attachments=moved).with_contacts(**entries), varied, t)


def _structure(model: RigModel, varied: VariedDimension, t: float) -> RigModel:
    """In the modes of the model. T: these in the modes as built"""
    c, T = model.components, model.rotation
    if len(T) != len(varied.stiffening):
        raise ValueError("the modes of this model are not those that it was built with: apply the dimension before")
    omega = np.sqrt(np.maximum(c.omega_squared, 0.0))
    growth = T.T @ function_of(np.expm1, t * varied.stiffening) @ T
    grown = omega[:, None] * growth * omega
    elastic = c.omega_squared > 0
    loss = np.where(elastic, np.diag(c.hysteretic), 0.0) / np.where(elastic, c.omega_squared, 1.0)
    softness = np.trace(c.residual) / np.trace(varied.built.residual) if varied.built.has_residual else 1.0
    there = replace(
        c,
        phi=c.phi + t * varied.phi @ T,
        residual=c.residual + softness * (_residual(varied, t) - varied.built.residual),
        hysteretic=c.hysteretic + np.sqrt(loss)[:, None] * grown * np.sqrt(loss),
    )
    return with_modal_stiffness(replace(model, components=there), np.diag(c.omega_squared) + grown)


def _residual(varied: VariedDimension, t: float) -> Floats:
    """(n_rows, n_rows) [m/N] of the model as built, after t steps: what the modes leave of the flexibility at rest, and
    nowhere less than half of what the stiffest direction has at first. Far from both ends the modes of a blend may be
    more flexible than all of them together."""
    built = varied.built
    if not built.has_residual:
        return built.residual
    elastic = built.omega_squared > 0
    omega, phi = np.sqrt(built.omega_squared[elastic]), (built.phi + t * varied.phi)[:, elastic]
    softened = function_of(np.exp, -t * varied.stiffening)[np.ix_(elastic, elastic)] / np.outer(omega, omega)
    left = built.flexibility_at_rest + varied.softened(t) - phi @ softened @ phi.T
    least = max(float(np.linalg.eigvalsh(built.residual)[0]), 0.0) / 2
    return function_of(lambda values: np.maximum(values, least), (left + left.T) / 2)


def _moved(attachment: Attachment, weights: Mapping[str, float], t: float) -> Attachment:
    points = {point: weight + t * weights.get(point, 0.0) for point, weight in attachment.points.items()}
    return replace(attachment, points=points) if any(weights.values()) else attachment
