"""What a user's own law says of itself, held against what it computes: told when its elements are made, not by Newton's
method that finds no way, or by a stability that is wrong. Each law is asked once."""

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp import hbm
from updamp.hbm.contact.law import force_for_analysis, is_of_its_force
from updamp.hbm.contact.memoryless import MemorylessLaw

# Of a made-up motion: time samples, and sizes, in m or another unit; some are within gaps, others beyond what a law is
# for.
_SAMPLES, _SIZES = 16, (1e-6, 1e-3, 1.0, 1e3, 1e6)
# Of the largest value, what two ways to compute one number may differ by; slopes are sums of steep and flat ones.
_ROUND_OFF, _SLOPES = 1e-9, 1e-6


class OwnLawError(ValueError):
    """A law that contradicts itself, or returns what is no force."""


@dataclass(frozen=True)
class _OfSome:
    """Parameters of some elements; those of any tell the same, so they do not make a law another one."""

    values: Any = field(compare=False)


def refuse_contradictions(law: Any, parameters: Any) -> None:
    """law: a `ContactLaw` that is none of this package, whose own are tested; parameters: of `ElementGroup`

    raises: OwnLawError where it contradicts itself, or returns what is no force; TypeError where it cannot be a key.
        What its own code raises is told where its force is computed.
    """
    if type(law).__module__.startswith(f"{hbm.__name__}.") or not all(len(value) for value in parameters):
        return
    try:
        hash(law)
    except TypeError:
        raise TypeError(
            f"{type(law).__name__} has no hash, by which compiled laws are kept: make it a @dataclass(frozen=True)"
        ) from None
    _refuse(law, _OfSome(parameters))


@lru_cache(maxsize=64)
def _refuse(law: Any, of_some: _OfSome) -> None:
    name, given = type(law).__name__, of_some.values
    parameters = type(given)(*(jnp.asarray(value)[0] for value in given))
    motions = [_motion(size, law.directions) for size in _SIZES]
    try:
        stiffness = np.asarray(law.reference_stiffness(parameters))
        forces = [law.force(*motion, parameters) for motion in motions]
    except Exception:
        return
    if stiffness.shape != (law.directions,) or not np.isfinite(stiffness).all():
        raise OwnLawError(
            f"{name}: reference_stiffness returns {stiffness}; {law.directions} finite numbers are needed in one "
            "dimension, one a direction"
        )
    for force, motion in zip(forces, motions, strict=True):
        _refuse_force(law, name, parameters, force, *motion)


def _motion(size: float, directions: int) -> tuple[jax.Array, jax.Array]:
    """Displacement and velocity, each (n_time, directions); no sample is at zero"""
    angle = 2 * np.pi * np.arange(_SAMPLES)[:, None] / _SAMPLES + 0.1 + np.arange(directions)
    return jnp.asarray(size * np.cos(angle)), jnp.asarray(-size * np.sin(angle))


def _refuse_force(
    law: Any, name: str, parameters: Any, force: Any, displacement: jax.Array, velocity: jax.Array
) -> None:
    shape, kind = np.shape(force), getattr(force, "dtype", type(force).__name__)
    if shape != displacement.shape:
        raise OwnLawError(
            f"{name}: force returns shape {shape} for a displacement of shape {displacement.shape}; the same is "
            "needed, (n_time, directions)"
        )
    if kind != np.float64:
        raise OwnLawError(f"{name}: force returns {kind}; real numbers in double precision, float64, are needed")
    if not law.rate_dependent and not _same(force, law.force(displacement, 0.7 * velocity, parameters), _ROUND_OFF):
        raise OwnLawError(f"{name}: rate_dependent is False, and force changes with the velocity: say True")
    if not hasattr(law, "cycles") and _remembers(law, parameters, displacement, velocity):
        raise OwnLawError(
            f"{name}: force at one time depends on the motion at others, and a law with a memory says through how many "
            "periods it marches, or its stability would be that of a law without: give it a field cycles, such as "
            "cycles: int = 2"
        )
    if isinstance(law, MemorylessLaw) and is_of_its_force(law, "sampled"):
        _refuse_sampled(law, name, parameters, displacement, velocity)


def _remembers(law: Any, parameters: Any, displacement: jax.Array, velocity: jax.Array) -> bool:
    """Whether a sample of the displacement or the velocity changes the force at others beyond its neighbours, which a
    law that averages between samples looks at, by more than it changes the mean that a law may count from. Not told
    where a force is no number: beyond what a law is for."""
    apart = np.abs(np.subtract.outer(np.arange(_SAMPLES), np.arange(_SAMPLES)))
    far = (np.minimum(apart, _SAMPLES - apart) > 1)[:, None, :, None]
    for by_sample in jax.jacfwd(lambda *motion: law.force(*motion, parameters), argnums=(0, 1))(displacement, velocity):
        slopes = np.asarray(by_sample)
        by_mean = slopes.mean(axis=2, keepdims=True, where=far)
        if np.isfinite(slopes).all() and np.abs((slopes - by_mean) * far).max() > _SLOPES * np.abs(slopes).max():
            return True
    return False


def _refuse_sampled(
    law: MemorylessLaw, name: str, parameters: Any, displacement: jax.Array, velocity: jax.Array
) -> None:
    """What is written out in NumPy has to be what JAX has."""

    def force(u: jax.Array, v: jax.Array) -> jax.Array:
        return force_for_analysis(law)(u, v, parameters)

    each = type(parameters)(*(np.asarray(value)[None, None] for value in parameters))
    found = law.sampled(np.asarray(displacement).T, np.asarray(velocity).T, each)
    if not _same(force(displacement, velocity), np.transpose(found.force), _ROUND_OFF):
        raise OwnLawError(f"{name}: sampled has another force than force")
    at, along, still = (displacement, velocity), jnp.ones_like(displacement), jnp.zeros_like(displacement)
    slopes = {
        "displacement": ((along, still), (found.by_displacement, found.by_last, found.by_next)),
        "velocity": ((still, along), (found.by_velocity,)),
    }
    for by, (direction, parts) in slopes.items():
        wanted, total = jax.jvp(force, at, direction)[1], np.zeros((_SAMPLES, 1))
        for part in parts:
            total = total if part is None else total + np.transpose(np.broadcast_to(part, (1, _SAMPLES)))
        if not _same(wanted, total, _SLOPES):
            raise OwnLawError(f"{name}: the slopes by {by} that sampled has are not those of force")


def _same(one: Any, other: Any, share: float) -> bool:
    """Where both are finite: beyond what a law is for it may be no number."""
    a, b = np.asarray(one), np.asarray(other)
    there: NDArray[np.bool_] = np.isfinite(a) & np.isfinite(b)
    largest = np.abs(a[there]).max(initial=0.0)
    return bool((np.abs(a - b)[there] <= share * largest).all())
