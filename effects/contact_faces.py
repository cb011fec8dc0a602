"""What effects of the contact have in common: where a contact element lies on its face, what a change of the normal
forces must leave as it is, and modifications of the contact law."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.effects.rig_model import RigModel
from updamp.geometry.contact_elements import LEFT, RIGHT, SAME_PLACE, ContactElements
from updamp.hbm.contact.modified.modified_law import ModifiedLaw

Floats = NDArray[np.float64]


def patches_of(model: RigModel) -> ContactElements:
    """raises: ValueError where the contacts are not laid over faces"""
    if model.patches is None or model.contacts is None:
        raise ValueError("this effect varies over contact faces, and the model has none: leave the effect out")
    return model.patches


def along_damper(patches: ContactElements) -> Floats:
    """(n,) place of each patch's point along z, from -1 at one end of its face to 1 at the other."""
    return _on_face(patches, lambda on: (patches.triangle[on][..., 2], patches.point[on, 2]))


def up_the_face(patches: ContactElements) -> Floats:
    """(n,) place of each patch's point along t1, from -1 at the lower edge of its face to 1 at the upper one."""
    return places_up_the_face(patches, patches.point[:, None])[:, 0]


def places_up_the_face(patches: ContactElements, places: Floats) -> Floats:
    """As `up_the_face`, for k places (n, k, 3) of each patch: (n, k)."""

    def coordinates(on: NDArray[np.bool_]) -> tuple[Floats, Floats]:
        t1 = patches.tangent1[on]
        return np.einsum("ecx,ex->ec", patches.triangle[on], t1), np.einsum("ekx,ex->ek", places[on], t1)

    return _on_face(patches, coordinates)


def laid_out_alike(one: ContactElements, other: ContactElements) -> bool:
    """Whether two sets of patches lie at the same places of their faces, however large these are."""
    if not np.array_equal(one.face, other.face):
        return False
    return all(np.allclose(of(one), of(other), rtol=0.0, atol=SAME_PLACE) for of in (along_damper, up_the_face))


def _on_face(patches: ContactElements, coordinates: Callable[[NDArray[np.bool_]], tuple[Floats, Floats]]) -> Floats:
    """Scaled so that the corners of each face's patches reach from -1 to 1."""
    scaled: dict[int, Floats] = {}
    for side in (LEFT, RIGHT):
        corners, place = coordinates(patches.face == side)
        middle, half = (corners.max() + corners.min()) / 2, (corners.max() - corners.min()) / 2
        scaled[side] = (place - middle) / half
    result = np.empty((len(patches), *scaled[LEFT].shape[1:]))
    for side, value in scaled.items():
        result[patches.face == side] = value
    return result


def with_totals_of(values: Floats, original: Floats, patches: ContactElements) -> Floats:
    """`values` scaled so that each face carries what it carries in `original`: (n,) [N]"""
    result = values.copy()
    for side in (LEFT, RIGHT):
        on = patches.face == side
        total = values[on].sum()
        result[on] *= original[on].sum() / total if total > 0 else 1.0
    return result


def entry(model: RigModel, name: str) -> Floats:
    """(n, ...) one entry of the contacts' parameters. raises: ValueError where the model has no contacts"""
    if model.contacts is None:
        raise ValueError("this effect is one of the contact, and the model has no contacts: leave the effect out")
    return np.array(getattr(model.contacts.parameters, name))


def modify_contacts(model: RigModel, law: type[ModifiedLaw], **entries: Any) -> RigModel:
    """The model with the law of its contacts modified by `law`.

    entries: what it adds to the parameters: numbers, the same for all elements, or (n,)
    raises: ValueError where the model has no contacts, or such without friction
    """
    each = np.ones(len(entry(model, "mu")))
    assert model.contacts is not None, "checked by entry"
    added = {name: value * each for name, value in entries.items()}
    return model.with_contacts(law.modify(model.contacts.law), **added)
