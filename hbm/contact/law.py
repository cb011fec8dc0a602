"""What a contact law is: one pure function of a period of relative displacement.

History is a scan inside the call, the tangent comes from forward-mode differentiation, nothing is remembered.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Protocol, runtime_checkable

import jax
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.harmonics import Harmonics

STICK, SLIP, SEPARATED = 0, 1, 2


class ContactLaw(Protocol):
    """A law for one element; the solver maps it over all elements of a group.

    parameters: a NamedTuple class, one scalar (or small vector) an entry and element
    directions: number of relative displacements of one element, 3 for (t1, t2, n)
    rate_dependent: whether `force` uses the velocity
    """

    def __hash__(self) -> int:
        """Laws are immutable; compiled functions are kept by law."""
        ...

    @property
    def parameters(self) -> type: ...

    @property
    def directions(self) -> int: ...

    @property
    def rate_dependent(self) -> bool: ...

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        """Force that resists the relative displacement, over one settled period, less that at rest.

        displacement, velocity: (n_time, directions) [m, m/s] -> (n_time, directions) [N]
        """
        ...

    def reference_stiffness(self, parameters: Any) -> jax.Array:
        """(directions,) stiffness [N/m] of the element as long as it neither slips nor separates."""
        ...


@runtime_checkable
class AveragedLaw(ContactLaw, Protocol):
    """A law that follows what happens between the time samples."""

    def averaged_force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        """As `force`, but what its Fourier coefficients are taken from."""
        ...


@runtime_checkable
class DecoupledLaw(ContactLaw, Protocol):
    """A law in which a motion in some directions changes the force in the same direction alone, though that force may
    depend on motions in other directions too: the derivatives in the former are taken together.
    """

    @property
    def decoupled_directions(self) -> tuple[int, ...]: ...


@runtime_checkable
class StickingLaw(ContactLaw, Protocol):
    """A law of which the motion tells where an element surely neither slips nor separates: its force is that of its
    reference springs then, and need not be evaluated.
    """

    def surely_sticks(self, displacement: NDArray[np.float64], parameters: Any, overshoot: float) -> NDArray[np.bool_]:
        """(n_elements,)

        displacement: (n_elements, directions, n_time) [m]; parameters: of all of them, in NumPy arrays
        overshoot: as in `sticking.stays_below_limit`
        """
        ...


class CompiledForces(Protocol):
    """A law's Fourier coefficients, compiled for certain harmonics and time samples, with tangents of their own.

    numbers: of the elements to evaluate; displacement: (n_elements, directions, n_coefficients) [m]
    w: angular frequency [rad/s], one for all elements or (n_elements,)
    parameters: of all elements, in NumPy arrays
    force: like displacement [N]; tangent: (n_elements, directions, n_coefficients, directions, n_coefficients) [N/m];
        by_frequency: like force, its derivative by w [N s], zeros to begin with, left alone where the law does not
        depend on the rate; what belongs to the elements of these numbers is written
    """

    def write_forces(
        self,
        numbers: NDArray[np.int64],
        displacement: NDArray[np.float64],
        w: float | NDArray[np.float64],
        parameters: Any,
        force: NDArray[np.float64],
    ) -> None: ...

    def write_with_tangents(
        self,
        numbers: NDArray[np.int64],
        displacement: NDArray[np.float64],
        w: float | NDArray[np.float64],
        parameters: Any,
        force: NDArray[np.float64],
        tangent: NDArray[np.float64],
        by_frequency: NDArray[np.float64],
    ) -> None: ...


@runtime_checkable
class CompiledHysteresis(CompiledForces, Protocol):
    """Forces of a law that does not depend on the rate, which also tell its loops, and how it answers what grows."""

    def write_perturbed_tangents(
        self,
        numbers: NDArray[np.int64],
        displacement: NDArray[np.float64],
        parameters: Any,
        growth: complex,
        tangent: NDArray[np.complex128],
    ) -> None:
        """growth: s / w, of the perturbation's e^(s t) in a motion at w."""
        ...

    def loop_areas(
        self, numbers: NDArray[np.int64], displacement: NDArray[np.float64], parameters: Any
    ) -> NDArray[np.float64]:
        """(len(numbers),) integral of f dx over a period by the trapezoidal rule [J]."""
        ...


@runtime_checkable
class CompiledFriction(CompiledForces, Protocol):
    """Forces that also say how they depend on a friction coefficient that varies over the period."""

    def by_friction(
        self,
        numbers: NDArray[np.int64],
        displacement: NDArray[np.float64],
        parameters: Any,
        mu_rows: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """(len(numbers), 2, n_coefficients, m) derivatives of the forces in t1 and t2 by m numbers that mu depends on.

        parameters: with mu (n_elements, n_time); mu_rows: (len(numbers), n_time, m) its derivatives
        """
        ...


@runtime_checkable
class CompiledStates(CompiledForces, Protocol):
    """Forces that tell what a contact does over a period without its samples."""

    def contact_states(
        self, numbers: NDArray[np.int64], displacement: NDArray[np.float64], parameters: Any
    ) -> NDArray[np.int64]:
        """(len(numbers),) of `observe.ContactState`; arguments as in `write_forces`"""
        ...


@runtime_checkable
class CompiledLaw(ContactLaw, Protocol):
    """A law that is written out a second time, in hbm/contact/compiled/, to be faster.

    `force` remains its definition, for whatever needs more than coefficients and their derivatives by the motion.
    """

    def compiled(self, harmonics: Harmonics, n_time: int) -> CompiledForces | None:
        """None where a law inside is in JAX alone."""
        ...


@runtime_checkable
class SumOfLaws(ContactLaw, Protocol):
    """A law whose force is the sum of those of others, with the same parameters: each is evaluated in its own way."""

    @property
    def parts(self) -> "tuple[ContactLaw, ...]": ...


@dataclass(frozen=True, eq=False)
class LawAt:
    """Elements in a motion, for derivatives by their law's parameters.

    displacement: (n_elements, directions, n_coefficients) [m]; tangent: (n_elements, directions, n_coefficients,
        directions, n_coefficients) of one of each element's copies [N/m]; parameters: of all elements, in NumPy arrays
    w: [rad/s]; harmonics: of the coefficients, 0 among them
    """

    displacement: NDArray[np.float64]
    tangent: NDArray[np.float64]
    parameters: Any
    w: float
    harmonics: Harmonics
    n_time: int

    @property
    def mean(self) -> int:
        """Place of the zero harmonic's coefficient"""
        return int(self.harmonics.slices[0].start)


@runtime_checkable
class LawOfMoves(ContactLaw, Protocol):
    """A law of which a parameter does what some motion does, so that its derivatives follow from the tangent."""

    def parameter_derivatives(self, entries: Sequence[str], at: LawAt) -> dict[str, NDArray[np.float64]] | None:
        """As `parameter_moves.friction_derivatives`; None where the tangent does not tell."""
        ...


@runtime_checkable
class FrictionLaw(ContactLaw, Protocol):
    """A law with stick, slip and separation in (t1, t2, n)."""

    def state(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        """(n_time,) STICK, SLIP or SEPARATED over the same period."""
        ...

    def normal_force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        """(n_time,) total pressing force [N], preload included."""
        ...


def decoupled_directions_of(law: ContactLaw) -> tuple[int, ...]:
    """See `DecoupledLaw`; none where the law does not say."""
    if isinstance(law, DecoupledLaw) and is_of_its_force(law, "decoupled_directions"):
        return law.decoupled_directions
    return ()


@lru_cache(maxsize=64)
def as_sticking_law(law: ContactLaw) -> StickingLaw | None:
    """Kept by law: to look at a protocol takes longer than to look at the elements."""
    return law if isinstance(law, StickingLaw) and is_of_its_force(law, "surely_sticks") else None


def parts_of(law: ContactLaw) -> tuple[ContactLaw, ...]:
    """See `SumOfLaws`; none where the law is no sum."""
    return law.parts if isinstance(law, SumOfLaws) and is_of_its_force(law, "parts") else ()


def compiled_forces_of(law: ContactLaw, harmonics: Harmonics, n_time: int) -> CompiledForces | None:
    """None where the law is in JAX alone."""
    return (
        law.compiled(harmonics, n_time) if isinstance(law, CompiledLaw) and is_of_its_force(law, "compiled") else None
    )


def is_of_its_force(law: ContactLaw, written_out: str) -> bool:
    """Whether what tells of a law's force a second time belongs to it: what is inherited by a law with a force of its
    own is another law's."""
    classes = type(law).__mro__

    def first_with(name: str) -> int:
        return next((i for i, one in enumerate(classes) if name in vars(one)), len(classes))

    return first_with(written_out) <= min(first_with("force"), first_with("averaged_force"))


def force_for_analysis(law: ContactLaw) -> Callable[[jax.Array, jax.Array, Any], jax.Array]:
    """The law's force samples that Fourier coefficients are taken from."""
    return law.averaged_force if isinstance(law, AveragedLaw) else law.force


def of_each(w: float | NDArray[np.float64], numbers: NDArray[np.int64]) -> NDArray[np.float64]:
    """(len(numbers) or 1, 1) w of the elements of these numbers, from one for all or (n_elements,)"""
    each = np.asarray(w, dtype=float).reshape(-1, 1)
    return each[numbers] if len(each) > 1 else each
