"""The coupled problem: linear structure, contact elements, excitation.

Every element is split into its reference springs (its stiffness while stuck and closed) and what departs from them,
g(x) = f_nl(x) - K_ref x. The springs join the linear structure exactly, so that an element which neither slips nor
separates has g = 0 with its tangent, and only the others enter the Newton equations:

    x - x_lin(w) + G(w) g(x) = 0,   x_lin = G_xe(w) p
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.harmonics import Harmonics, whole_number
from updamp.hbm.problem.element_checks import refuse_rows, refuse_unmoved, warn_of_moving_mean
from updamp.hbm.problem.elements import ElementGroup, departure_only, departures
from updamp.hbm.problem.elements_together import departures_only_together, departures_together
from updamp.hbm.problem.linear_model import LinearModel, stuck_on
from updamp.hbm.problem.mirror import Mirror, acts_symmetrically, half_groups, half_structure, is_own_image
from updamp.hbm.problem.mirror_search import driven_alone, laws_are_mirrored, mirror_driven_at

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_EPS = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class Excitation:
    """Harmonic point force force*cos(w t) on one row of the linear model.

    row: row number, from 0 on, as `LinearModel.row` of a point tells it; force: amplitude [N]

    raises: ValueError for a row that is no whole number or negative, and for a complex force
    """

    row: int
    force: float

    def __post_init__(self) -> None:
        row = whole_number(self.row)
        if row is None or row < 0:
            raise ValueError(
                f"row = {self.row}: a row of the linear model, from 0 on; that of a point is model.row(name)"
            )
        if isinstance(self.force, complex):
            raise ValueError(f"force = {self.force}: an amplitude is a real number; its phase is 0")
        object.__setattr__(self, "row", row)

    def at(self, parameter: float) -> tuple[float, "Excitation"]:
        """parameter: the angular frequency"""
        return parameter, self

    def rates(self, parameter: float) -> tuple[float, float]:  # noqa: ARG002  the same at all frequencies
        return 1.0, 0.0


class Forcing(Protocol):
    """What varies along a branch: the frequency at constant force (`Excitation`), or the force
    (hbm/continuation/first_point.py)."""

    def at(self, parameter: float) -> tuple[float, Excitation]:
        """Angular frequency [rad/s] and excitation at a place of the branch."""
        ...

    def rates(self, parameter: float) -> tuple[float, float]:
        """Derivatives of angular frequency and force with respect to the parameter."""
        ...


@dataclass(frozen=True, eq=False)
class Departure:
    """g(x) = f_nl(x) - K_ref x with its tangent.

    value: (n_relative, n_coefficients) [N]
    tangents: for each group (n_elements, d, n_coefficients, d, n_coefficients) [N/m]
    frequency_derivative: (n_relative, n_coefficients) [N s], zero for rate-independent laws
    """

    value: Floats
    tangents: tuple[Floats, ...]
    frequency_derivative: Floats


@dataclass(frozen=True, eq=False)
class NonlinearSystem:
    """free: the linear structure without the elements; groups: their rows cover 0..n_relative-1, each once.

    mirror: what might be a symmetry of the problem; whether it is one, `half` finds out. None: it is looked for where
        the excitation is known (hbm/problem/mirror_search.py), unless `as_a_whole`
    mean_held: that the mean position is meant to be held where elements push one way alone and harmonic 0 is left
        out, of which there is a warning otherwise

    raises: ValueError where there is no group, where the rows of the groups overlap or leave some out, where the
        time samples do not resolve the highest harmonic, and where an element sees no motion
    """

    free: LinearModel
    groups: tuple[ElementGroup, ...]
    harmonics: Harmonics
    time_samples: int
    mirror: Mirror | None = None
    as_a_whole: bool = False
    mean_held: bool = False

    def __post_init__(self) -> None:
        if (samples := whole_number(self.time_samples)) is None:
            raise ValueError(f"time_samples = {self.time_samples}: a whole number of samples a period is needed")
        object.__setattr__(self, "time_samples", samples)
        self.harmonics.refuse_too_few(samples)
        if not self.groups:
            raise ValueError("no elements: of a linear structure a `CubicSpring` of coefficient 0 makes a system")
        refuse_rows(self.groups, self.free.n_relative)
        if not self.as_a_whole:  # in half the motions an element in the middle may be at rest
            refuse_unmoved(self.groups, self._moves)
        if not self.mean_held:
            warn_of_moving_mean(self.groups, self.harmonics)

    @property
    def _moves(self) -> NDArray[np.bool_]:
        """(n_relative,)"""
        n = self.free.n_relative
        return np.asarray(self.free.phi[:n].any(axis=1) | self.free.residual[:n].any(axis=1))

    def refuse_row(self, row: int) -> None:
        """raises: ValueError where the model has no such row to be driven at"""
        if not 0 <= row < self.free.n_rows:
            points = ", ".join(f"{self.free.row(name)} is point '{name}'" for name in self.free.points[:6])
            raise ValueError(f"row = {row}: the model has rows 0 to {self.free.n_rows - 1}{points and f'; {points}'}")

    @cached_property
    def reference_stiffness(self) -> Floats:
        """(n_relative,) [N/m]"""
        stiffness = np.zeros(self.free.n_relative)
        for group in self.groups:
            stiffness[group.rows] = group.reference_stiffness()
        return stiffness

    @cached_property
    def stuck(self) -> LinearModel:
        """The structure with every element on its reference springs.

        raises: ValueError where harmonic 0 is kept and a mode has no stiffness, or a negative one
        """
        stuck = stuck_on(self.free, self.reference_stiffness)
        squared = stuck.omega_squared
        round_off = len(squared) * _EPS * np.abs(squared).max(initial=0.0)
        if 0 in self.harmonics.orders and len(squared) and squared.min() < -round_off:
            raise ValueError(
                f"harmonic 0: a motion of the structure with all contacts stuck has a negative stiffness, omega^2 = "
                f"{squared.min():.4g} rad^2/s^2: it does not rest where displacements are counted from; give K about "
                "the position in which it rests, or look for a wrong sign in it"
            )
        if 0 in self.harmonics.orders and len(squared) and squared.min() <= round_off:
            raise ValueError(
                "harmonic 0: a motion of the structure with all contacts stuck has no stiffness, so that no mean force "
                "can be held; leave harmonic 0 out, such as Harmonics((1, 3, 5)), or hold the structure"
            )
        return stuck

    def departure(self, x: Floats, w: float) -> Departure:
        """g and its tangent at the relative displacements x: (n_relative, n_coefficients) [m]."""
        value, rate = np.empty_like(x), np.zeros_like(x)
        tangents = []
        for group in self.groups:
            found = departures(group, x[group.rows], w, self.harmonics, self.time_samples)
            value[group.rows] = found.force
            tangents.append(found.tangent)
            if found.frequency_derivative is not None:
                rate[group.rows] = found.frequency_derivative
        return Departure(value, tuple(tangents), rate)

    def departures(self, x: Floats, w: Floats) -> list[Departure]:
        """As `departure`, of each of several motions: x (n_relative, n_coefficients, n) at w (n,)"""
        value, rate = np.empty_like(x), np.zeros_like(x)
        tangents: list[list[Floats]] = [[] for _ in w]
        for group in self.groups:
            found = departures_together(group, _one_by_one(x[group.rows]), w, self.harmonics, self.time_samples)
            for i, of_motion in enumerate(found):
                value[group.rows, :, i] = of_motion.force
                tangents[i].append(of_motion.tangent)
                if of_motion.frequency_derivative is not None:
                    rate[group.rows, :, i] = of_motion.frequency_derivative
        return [
            Departure(np.ascontiguousarray(value[..., i]), tuple(each), np.ascontiguousarray(rate[..., i]))
            for i, each in enumerate(tangents)
        ]

    def departure_value(self, x: Floats, w: float) -> Floats:
        """g alone."""
        value = np.empty_like(x)
        for group in self.groups:
            value[group.rows] = departure_only(group, x[group.rows], w, self.harmonics, self.time_samples)
        return value

    def departure_values(self, x: Floats, w: Floats, known: "tuple[NonlinearSystem, Floats] | None" = None) -> Floats:
        """g of several motions at once: x (n_relative, n_coefficients, n) at w (n,), and g like it

        known: another system and its g at the same x and w; groups that are in both are not evaluated again
        """
        value = np.empty_like(x)
        other, found = known or (None, x)
        alike = other is not None and (other.harmonics, other.time_samples) == (self.harmonics, self.time_samples)
        for group in self.groups:
            if other is not None and alike and any(group is one for one in other.groups):
                value[group.rows] = found[group.rows]
                continue
            motions = _one_by_one(x[group.rows])
            forces = departures_only_together(group, motions, w, self.harmonics, self.time_samples)
            value[group.rows] = np.moveaxis(forces, 0, -1)
        return value

    def element_forces(self, x: Floats, w: float) -> Floats:
        """f_nl(x): (n_relative, n_coefficients) [N]."""
        return self.departure_value(x, w) + self.reference_stiffness[:, None] * x

    @cached_property
    def half(self) -> "NonlinearSystem | None":
        """The symmetric motions alone (hbm/problem/mirror.py); None where the problem is not its own mirror image."""
        if self.mirror is None or not is_own_image(self.free, self.groups, self.mirror):
            return None
        return self.halved(self.mirror)

    def halved(self, mirror: Mirror) -> "NonlinearSystem":
        """The symmetric motions alone, of a problem that is its own mirror image."""
        free, groups = half_structure(self.free, mirror), half_groups(self.groups, mirror)
        return replace(self, free=free, groups=groups, mirror=None, as_a_whole=True)

    @cached_property
    def other_half(self) -> "NonlinearSystem | None":
        """Changes that are the opposite of their image, about a symmetric motion on the same rows as `half`."""
        if self.half is None or self.mirror is None:
            return None
        return replace(self.half, free=half_structure(self.free, self.mirror, -1.0))

    def half_driven_at(self, row: int) -> "tuple[NonlinearSystem, Mirror] | None":
        """`half`, where a force on this row is its own mirror image too, and what leads back to the whole."""
        self.refuse_row(row)
        if self.as_a_whole:
            return None
        if self.mirror is None:
            return self._found_half(row)
        if self.half is None or not acts_symmetrically(self.free, self.mirror, row):
            return None
        return self.half, self.mirror

    def _found_half(self, row: int) -> "tuple[NonlinearSystem, Mirror] | None":
        """As `half_driven_at`, by a mirror image that is found. The laws are tried last: that takes longest."""
        free = driven_alone(self.free, row)
        mirror = mirror_driven_at(free, self.groups, row)
        if mirror is None or (half := replace(self, free=free, mirror=mirror).half_driven_at(row)) is None:
            return None
        w = float(np.sqrt(self.free.omega_squared.max()))  # any: what a law depends on has no sides
        mirrored = laws_are_mirrored(lambda x: self.departure_value(x, w), mirror, self.harmonics.n_coefficients)
        return half if mirrored else None


def _one_by_one(motions: Floats) -> Floats:
    """With the last axis first"""
    return np.ascontiguousarray(np.moveaxis(motions, -1, 0))
