"""Rounded edges of the damper's faces."""

import numpy as np
from numpy.typing import NDArray

from updamp.effects.contact_faces import entry, patches_of, places_up_the_face
from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.geometry.contact_elements import LEFT, RIGHT, ContactElements

Floats = NDArray[np.float64]

DIVISIONS = 12  # of a patch's edge, to average over it
_SAME = 1e-9  # of the depth: less is round-off


def apply(model: RigModel, values: Values) -> RigModel:
    """A gap of depth ((|s| - 1/2) / (1/2))^2 beyond |s| = 1/2, s up the face, averaged over each patch.

    The faces move together until each carries what it carried before: edges lose load, the middle takes it.

    raises: ValueError where each patch reaches from edge to edge: all of them would lose the same
    """
    if values["depth"] == 0:
        return model
    patches = patches_of(model)
    n0, kn = entry(model, "n0"), entry(model, "kn")
    rounded = profile(patches)
    if np.ptp(rounded) < _SAME:
        raise ValueError(
            f"edge_gap: each of the {len(rounded)} contact elements reaches from the upper to the lower edge of its "
            "face, so that none lies at an edge alone; state contact_strips = 2 in the mesh preset, or more "
            "contact_elements"
        )
    opening = values["depth"] * rounded + entry(model, "gap") - n0 / kn
    carried = np.maximum(n0 - kn * entry(model, "gap"), 0.0)
    for side in (LEFT, RIGHT):
        on = patches.face == side
        opening[on] -= approach(opening[on], kn[on], float(carried[on].sum()))
    return model.with_contacts(n0=kn * np.maximum(-opening, 0.0), gap=np.maximum(opening, 0.0))


def profile(patches: ContactElements) -> Floats:
    """(n,) mean over each patch of ((|s| - 1/2) / (1/2))^2 beyond |s| = 1/2."""
    s = places_up_the_face(patches, _spread_over(patches.triangle))
    return np.asarray((np.maximum(2 * np.abs(s) - 1, 0.0) ** 2).mean(axis=1))


def approach(opening: Floats, stiffness: Floats, total: float) -> float:
    """d with sum of stiffness max(d - opening, 0) = total: exact, segment by segment."""
    order = np.argsort(opening)
    places, sums = opening[order], np.cumsum(stiffness[order])
    forces = sums * places - np.cumsum(stiffness[order] * places)  # as each spring comes into contact
    last = int(np.searchsorted(forces, total, side="right")) - 1
    return float(places[last] + (total - forces[last]) / sums[last])


def _spread_over(triangle: Floats) -> Floats:
    """(n, k, 3) centroids of equal parts of each triangle (n, 3, 3)."""
    d = DIVISIONS
    upright = [(i + 1 / 3, j + 1 / 3) for i in range(d) for j in range(d - i)]
    turned = [(i + 2 / 3, j + 2 / 3) for i in range(d) for j in range(d - 1 - i)]
    a, b = np.array(upright + turned).T / d
    weights = np.stack([1 - a - b, a, b])
    return np.einsum("ck,ecx->ekx", weights, triangle)


EFFECT = Effect(
    "edge_gap",
    "the upper and lower edges of the damper's faces are rounded and do not touch at first",
    (
        EffectParameter(
            "depth", 0.0, 0.0, 5e-6, 3e-7, "m", "assumed: form error of ground faces, tenths of a micrometre to some"
        ),
    ),
    apply,
)
