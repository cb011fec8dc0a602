"""Derivatives of the elements' forces with respect to their law's parameters."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.law import ContactLaw, force_for_analysis
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup, elements_a_batch, in_batches, samples

Floats = NDArray[np.float64]


def law_derivatives(
    group: ElementGroup, entries: tuple[str, ...], displacement: Floats, w: float, harmonics: Harmonics, n_time: int
) -> dict[str, Floats]:
    """df_nl/d(entry) of each element by its own parameters, by forward-mode differentiation through the hysteresis.

    entries: fields of the law's parameters; displacement: (n_elements, directions, n_coefficients) [m]
    returns: entry -> (n_elements, directions, n_coefficients, *shape of the entry of one element)
    """
    derivatives = _compiled(group.law, entries, harmonics, n_time)(displacement, w, group.parameters)
    return {entry: np.asarray(d) for entry, d in zip(entries, derivatives, strict=True)}


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
