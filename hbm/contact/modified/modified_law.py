"""Laws put around a friction law: each changes what the inner one sees, or what comes out of it.

They are stacked in one order whatever order they are put on in: by `rank`, the largest outermost.
"""

from collections import namedtuple
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, ClassVar

import jax
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.law import AveragedLaw, ContactLaw, DecoupledLaw, FrictionLaw, StickingLaw

# Parameters of laws around laws: those of the inner one and the entries that the outer one adds, in one NamedTuple.
#
# So mu, kt, kn, n0, ... are found under their names whatever has been put around the basic law.


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
        return _again, (name, fields, tuple(self))

    return type(name, (namedtuple(name, fields),), {"__slots__": (), "__reduce__": reduce})


def _again(name: str, fields: tuple[str, ...], values: tuple[Any, ...]) -> Any:
    return parameter_type(name, fields)(*values)


Seen = tuple[jax.Array, jax.Array, Any]


@dataclass(frozen=True)
class LawAround:
    """A friction law (see hbm/contact/law.py) made of another one; as it stands it changes nothing.

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
    def rate_dependent(self) -> bool:
        return bool(self.inner.rate_dependent)

    def inside(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> Seen:
        """Displacement, velocity and parameters that the inner law sees."""
        return displacement, velocity, parameters

    def outside(self, force: jax.Array, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        """(n_time, 3) the force, from that of the inner law [N]."""
        return force

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        seen = self.inside(displacement, velocity, parameters)
        return self.outside(self.inner.force(*seen), displacement, velocity, parameters)

    def averaged_force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        seen = self.inside(displacement, velocity, parameters)
        return self.outside(averaged(self.inner)(*seen), displacement, velocity, parameters)

    def reference_stiffness(self, parameters: Any) -> jax.Array:
        stiffness: jax.Array = self.inner.reference_stiffness(parameters)
        return stiffness

    def normal_force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        normal: jax.Array = self.inner.normal_force(*self.inside(displacement, velocity, parameters))
        return normal

    def state(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        state: jax.Array = self.inner.state(*self.inside(displacement, velocity, parameters))
        return state

    def compression(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        """(n_time,) of the normal spring, negative where open [m]"""
        return compression(self.inner, *self.inside(displacement, velocity, parameters))

    @classmethod
    def put_around(cls, law: ContactLaw) -> ContactLaw:
        """This law around `law`, at its rank among those that are around it already; once only.

        raises: ValueError for a law without friction
        """
        if isinstance(law, cls):
            return law
        if isinstance(law, LawAround) and law.rank > cls.rank:
            return replace(law, inner=cls.put_around(law.inner))
        if not isinstance(law, FrictionLaw) or not hasattr(law, "cycles"):
            raise ValueError(f"{cls.__name__} goes around a law of friction with three directions, not {law}")
        return cls(law)


def alone_in(law: ContactLaw) -> tuple[int, ...]:
    """Directions in which a motion acts on the force in that direction alone: a law around it that treats every
    direction by itself, but for what the normal one does to the others, has the same."""
    return law.acting_alone if isinstance(law, DecoupledLaw) else ()


def sticks_with_friction(
    law: ContactLaw, mu: NDArray[np.float64], displacement: NDArray[np.float64], parameters: Any, between: float
) -> NDArray[np.bool_]:
    """As `StickingLaw.surely_sticks` of the law with friction coefficients mu (n_elements,); nowhere if it cannot
    tell."""
    if not isinstance(law, StickingLaw):
        return np.zeros(len(displacement), dtype=bool)
    return law.surely_sticks(displacement, parameters._replace(mu=mu), between)


def averaged(law: FrictionLaw) -> Callable[[jax.Array, jax.Array, Any], jax.Array]:
    """What the Fourier coefficients of the law's force are taken from."""
    return law.averaged_force if isinstance(law, AveragedLaw) else law.force


def compression(law: FrictionLaw, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
    """(n_time,) of the law's normal spring, negative where open [m]"""
    if isinstance(law, LawAround):
        return law.compression(displacement, velocity, parameters)
    shift: jax.Array = parameters.n0 / parameters.kn - parameters.gap
    return shift + displacement[:, 2]
