"""Round a corner at which the branch turns back: a fold between two pieces, without a rounded top.

Where a contact changes its state the equations have a kink, r(x, w) is one function on this side of it and another on
the far side, and the branch may meet the kink from this side and leave it on the far side backwards. No plane ahead of
the corner is then met by the branch, however small the step, and Newton's method goes back and forth over the kink.

As in the continuation of piecewise linear equations (Katzenelson 1965, Bell Syst. Tech. J. 44) the far side's own
tangent tells where the branch goes on. Its sign follows from continuity: with n the kink's normal the Jacobians differ
by a n^T, so that ahead of the corner, along the old tangent t, r = c a (n.t) with c > 0, and the old Jacobian times the
new tangent t' is -a (n.t'). Both t and t' cross the kink the same way, hence their product is negative.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from updamp.hbm.branch import BranchPoint
from updamp.hbm.jacobian import factorise
from updamp.hbm.metric import Move
from updamp.hbm.newton import Equation, evaluate
from updamp.hbm.system import Excitation, NonlinearSystem
from updamp.hbm.tangent import apply_tangent

# Arc ahead of the last point at which the far side is looked at: one that is too short is still on this side, one that
# is too long has met the next kink.
_AHEAD = (1e-3, 3e-3, 1e-2)
# Steps on the far side, by that length: long enough to come out beyond the corner, wherever before it the kink lies.
_STEPS = (10.0, 3.0)


@dataclass(frozen=True, eq=False)
class Way:
    """A direction, of unit length in the metric of the last point, in which the branch may go on.

    start: (x, w) beyond the kink; along: (dx, dw); steps: to try from there. A guess that began at the last point
    would lie on this side of the kink, where Newton's method finds the branch it came along.
    """

    start: Move
    along: Move
    steps: tuple[float, ...]


def ways_on(system: NonlinearSystem, excitation: Excitation, last: BranchPoint) -> Iterator[Way]:
    """Ways on beyond a corner close to `last`.

    First those that cross the kink; with several kinks close together the sign may fail, so the others come after.
    """
    here = evaluate(system, excitation, last.x, last.w)
    backwards = []
    for ahead in _AHEAD:
        there = evaluate(system, excitation, last.x + ahead * last.tangent_x, last.w + ahead * last.tangent_w)
        try:
            jacobian = factorise(there.receptance, there.departure)
        except scipy.linalg.LinAlgError:
            continue
        dx, dw = -jacobian.solve(there.frequency_derivative(excitation)), 1.0
        length = last.metric.length((dx, dw))
        if not 0 < length < np.inf:
            continue
        crosses = np.vdot(_derivative(here, excitation, (dx, dw)), there.residual) < 0
        length = length if crosses else -length
        steps = tuple(share * ahead for share in _STEPS)
        yield Way((there.x, there.w), (dx / length, dw / length), steps)
        backwards.append(Way((there.x, there.w), (-dx / length, -dw / length), steps))
    yield from backwards


def _derivative(equation: Equation, excitation: Excitation, move: Move) -> np.ndarray:
    """Of the residual along a move, by the equation's own Jacobian."""
    dx, dw = move
    forces = apply_tangent(equation.receptance.system, equation.departure, dx)
    derivative: np.ndarray = dx + equation.receptance.apply(forces) + dw * equation.frequency_derivative(excitation)
    return derivative
