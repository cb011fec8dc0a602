"""Modified friction laws: each changes the arguments of the law inside it, or the force that comes out.

They are nested in one order whatever order they are applied in: by `rank`, the largest outermost. The parameters of a
modified law are one NamedTuple, those of the inner law and the entries that the modification adds: so mu, kt, kn,
n0, ... are found under their names however often the basic law has been modified.
"""

from collections import namedtuple
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, ClassVar

import jax
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.law import ContactLaw, FrictionLaw, as_sticking_law, force_for_analysis


def with_entries(parameters: Any, **entries: Any) -> Any:
    """The NamedTuple with these entries: those that it has are replaced, the others added behind."""
    new = {name: value for name, value in entries.items() if name not in parameters._fields}
    replaced = parameters._replace(**{name: value for name, value in entries.items() if name not in new})
    return extended_type(type(parameters), tuple(new))(*replaced, *new.values()) if new else replaced


def extended_type(base: type, entries: tuple[str, ...]) -> type:
    """A NamedTuple class with the fields of `base` and these behind."""
    fields: tuple[str, ...] = base._fields  # type: ignore[attr-defined]
    return parameter_type(base.__name__, (*fields, *(e for e in entries if e not in fields)))


@lru_cache(maxsize=256)
def parameter_type(name: str, fields: tuple[str, ...]) -> type:
    """One class for one set of fields: compiled functions are kept by it. It can be sent to other processes."""

    def reduce(self: Any) -> Any:
        return _rebuilt, (name, fields, tuple(self))

    return type(name, (namedtuple(name, fields),), {"__slots__": (), "__reduce__": reduce})


def _rebuilt(name: str, fields: tuple[str, ...], values: tuple[Any, ...]) -> Any:
    return parameter_type(name, fields)(*values)


LawArguments = tuple[jax.Array, jax.Array, Any]


@dataclass(frozen=True)
class ModifiedLaw:
    """A friction law (see hbm/contact/law.py) made of another one; the base class changes nothing.

    inner: the law inside; cycles: hysteresis cycles marched, 0 for those of `inner`
    entries: names of the parameters it needs beside those of `inner`
    """

    inner: Any
    cycles: int = 0
    directions: ClassVar[int] = 3
    rank: ClassVar[int] = 50
    entries: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        if self.cycles:
            object.__setattr__(self, "inner", replace(self.inner, cycles=self.cycles))
        else:
            object.__setattr__(self, "cycles", self.inner.cycles)

    @property
    def parameters(self) -> type:
        return extended_type(self.inner.parameters, self.entries)

    @property
    def settles_in(self) -> float:
        """Cycles after which the slider repeats itself: arguments that are periodic too change nothing in that"""
        return float(getattr(self.inner, "settles_in", np.inf))

    @property
    def rate_dependent(self) -> bool:
        return bool(self.inner.rate_dependent)

    def inner_arguments(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> LawArguments:
        """Displacement, velocity and parameters that the inner law is given."""
        return displacement, velocity, parameters

    def outer_force(self, force: jax.Array, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        """(n_time, 3) the force, from that of the inner law [N]."""
        return force

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        inner = self.inner_arguments(displacement, velocity, parameters)
        return self.outer_force(self.inner.force(*inner), displacement, velocity, parameters)

    def averaged_force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        inner = self.inner_arguments(displacement, velocity, parameters)
        return self.outer_force(force_for_analysis(self.inner)(*inner), displacement, velocity, parameters)

    def reference_stiffness(self, parameters: Any) -> jax.Array:
        stiffness: jax.Array = self.inner.reference_stiffness(parameters)
        return stiffness

    def normal_force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        normal: jax.Array = self.inner.normal_force(*self.inner_arguments(displacement, velocity, parameters))
        return normal

    def state(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        state: jax.Array = self.inner.state(*self.inner_arguments(displacement, velocity, parameters))
        return state

    def compression(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        """(n_time,) of the normal spring, negative where open [m]"""
        return compression(self.inner, *self.inner_arguments(displacement, velocity, parameters))

    def rest_compression(self, parameters: Any) -> NDArray[np.float64]:
        """As the function of that name"""
        return rest_compression(self.inner, parameters)

    @classmethod
    def modify(cls, law: ContactLaw) -> ContactLaw:
        """The law modified in this way, at its rank among the modifications that it has already; once only.

        raises: ValueError for a law without friction
        """
        if isinstance(law, cls):
            return law
        if isinstance(law, ModifiedLaw) and law.rank > cls.rank:
            return replace(law, inner=cls.modify(law.inner))
        if not isinstance(law, FrictionLaw) or not hasattr(law, "cycles"):
            raise ValueError(f"{cls.__name__} modifies a law of friction with three directions, not {law}")
        return cls(law)


def sticks_with_friction(
    law: ContactLaw, mu: NDArray[np.float64], displacement: NDArray[np.float64], parameters: Any, overshoot: float
) -> NDArray[np.bool_]:
    """As `StickingLaw.surely_sticks` of the law with friction coefficients mu (n_elements,); nowhere if it cannot
    tell."""
    if (telling := as_sticking_law(law)) is None:
        return np.zeros(len(displacement), dtype=bool)
    return telling.surely_sticks(displacement, parameters._replace(mu=mu), overshoot)


def compression(law: FrictionLaw, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
    """(n_time,) of the law's normal spring, negative where open [m]"""
    if isinstance(law, ModifiedLaw):
        return law.compression(displacement, velocity, parameters)
    shift: jax.Array = parameters.n0 / parameters.kn - parameters.gap
    return shift + displacement[:, 2]


def rest_compression(law: FrictionLaw, parameters: Any) -> NDArray[np.float64]:
    """(n_elements,) of the law's normal spring where nothing has moved, negative where open [m], in NumPy.

    What moves adds the normal displacement, as `compression` has it.
    """
    if isinstance(law, ModifiedLaw):
        return law.rest_compression(parameters)
    return np.asarray(parameters.n0) / np.asarray(parameters.kn) - np.asarray(parameters.gap)
