"""Derivatives of the elements' forces with respect to their law's parameters: from the tangent where the law tells how
(`hbm/contact/parameter_moves.py`), else by forward-mode differentiation through the hysteresis.
"""

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.law import ContactLaw, LawAt, LawOfMoves, force_for_analysis
from updamp.hbm.contact.parameter_moves import derivatives_of
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.laws_in_jax import elements_a_batch, in_batches, samples

Floats = NDArray[np.float64]


def law_derivatives(
    group: ElementGroup,
    entries: tuple[str, ...],
    displacement: Floats,
    departure: Floats,
    w: float,
    harmonics: Harmonics,
    n_time: int,
) -> Mapping[str, Floats]:
    """df_nl/d(entry) of each element by its own parameters, all of its copies together.

    entries: fields of the law's parameters; displacement: (n_elements, directions, n_coefficients) [m]
    departure: (n_elements, directions, n_coefficients, directions, n_coefficients) tangent there, less the reference
        springs, of all copies [N/m]
    returns: entry -> (n_elements, directions, n_coefficients, *shape of the entry of one element)
    """
    found = None
    if _is_law_of_moves(group.law) and 0 in harmonics.orders:
        at = LawAt(displacement, _of_one(group, departure), group.values, w, harmonics, n_time)
        found = derivatives_of(group.law, entries, at)
    if found is None:
        evaluate = _compiled(group.law, entries, harmonics, n_time)
        found = dict(zip(entries, map(np.asarray, evaluate(displacement, w, group.parameters)), strict=True))
    return {entry: group.of_all_copies(derivative) for entry, derivative in found.items()}


@lru_cache(maxsize=64)
def _is_law_of_moves(law: ContactLaw) -> bool:
    """Kept by law: to look at a protocol takes as long as the derivatives."""
    return isinstance(law, LawOfMoves)


def _of_one(group: ElementGroup, departure: Floats) -> Floats:
    """The tangent of one of each element's copies, its reference springs included."""
    n, d, c = departure.shape[:3]
    copies = np.ones(n) if group.copies is None else group.copies
    tangent = departure / copies[:, None, None, None, None]
    np.einsum("eii->ei", tangent.reshape(n, d * c, d * c))[:] += np.repeat(group.stiffness_of_one, c, axis=1)
    return tangent


@lru_cache(maxsize=32)
def _compiled(law: ContactLaw, entries: tuple[str, ...], harmonics: Harmonics, n_time: int) -> Callable[..., Any]:
    analysis, force_samples = harmonics.analysis(n_time), force_for_analysis(law)

    def one(coefficients: jax.Array, w: jax.Array, parameters: Any) -> Any:
        displacement, velocity = samples(coefficients, w, harmonics, n_time)

        def force(values: tuple[jax.Array, ...]) -> jax.Array:
            changed = parameters._replace(**dict(zip(entries, values, strict=True)))
            return jnp.matmul(analysis, force_samples(displacement, velocity, changed)).T

        return jax.jacfwd(force)(tuple(getattr(parameters, entry) for entry in entries))

    return jax.jit(in_batches(one, elements_a_batch(len(entries))))
