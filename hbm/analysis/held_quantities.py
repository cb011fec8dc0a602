"""What is held while a parameter changes: the frequency, the place along the branch, or the phase of a response."""

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.newton.equation import Equation
from updamp.hbm.newton.newton import Arc
from updamp.hbm.newton.observe import response
from updamp.hbm.problem.system import Excitation

Floats = NDArray[np.float64]


class HeldQuantity(Protocol):
    """A linear condition on the change of a solved point.

    rows: rows of the linear model whose response it looks at
    """

    @property
    def rows(self) -> tuple[int, ...]: ...

    def change(self, dx: Floats, dw: Floats, dy: Floats) -> Floats:
        """What is to be zero: (n,) for n changes.

        dx: (n_relative, n_coefficients, n) [m]; dw: (n,) [rad/s]; dy: (len(rows), n_coefficients, n) [m]
        """
        ...


@dataclass(frozen=True)
class FixedFrequency:
    rows: ClassVar[tuple[int, ...]] = ()

    def change(self, dx: Floats, dw: Floats, dy: Floats) -> Floats:  # noqa: ARG002 - the protocol's arguments
        return dw


@dataclass(frozen=True, eq=False)
class FixedArc:
    """The point moves on the plane across the branch's tangent; well-defined at folds too."""

    arc: Arc
    rows: ClassVar[tuple[int, ...]] = ()

    @staticmethod
    def at(point: BranchPoint) -> "FixedArc":
        return FixedArc(Arc(point.x, point.w, point.tangent, point.metric))

    def change(self, dx: Floats, dw: Floats, dy: Floats) -> Floats:  # noqa: ARG002 - the protocol's arguments
        (tangent_x, tangent_w), metric = self.arc.tangent, self.arc.metric
        along = np.tensordot(metric.weights**2 * tangent_x, dx, axes=2)
        return np.asarray(along + tangent_w * dw / metric.scale_w**2)


@dataclass(frozen=True, eq=False)
class FixedPhase:
    """The phase of a row's first harmonic against the excitation stays: resonance by phase.

    amplitude: complex first harmonic of the row at the point [m]
    """

    row: int
    amplitude: complex
    harmonics: Harmonics

    @staticmethod
    def at(equation: Equation, excitation: Excitation, row: int) -> "FixedPhase":
        harmonics = equation.receptance.system.harmonics
        y = response(equation, excitation, np.array([row]))
        return FixedPhase(row, complex(harmonics.amplitude(y[0], 1)), harmonics)

    @property
    def rows(self) -> tuple[int, ...]:
        return (self.row,)

    def change(self, dx: Floats, dw: Floats, dy: Floats) -> Floats:  # noqa: ARG002 - the protocol's arguments
        return np.asarray((self.harmonics.amplitude(dy[0].T, 1) / self.amplitude).imag)
