"""A resonance followed in the force, as a result that shows itself."""

from dataclasses import dataclass
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.newton.observe import ContactState
from updamp.hbm.resonance.resonance_curve import ResonanceCurve
from updamp.report.markup import number, table

if TYPE_CHECKING:
    from updamp.pictures.style import NotebookFigure

MM = 1e3  # m to mm
_TURNS = 4  # turns that are told


@dataclass(frozen=True, eq=False, repr=False)
class Resonance:
    """Frequency, receptance and damping at resonance against force.

    data: every point that was solved on the way (`hbm/resonance/resonance_curve.py`); the properties below have those
    at the forces asked for, in their order
    """

    data: ResonanceCurve

    def __len__(self) -> int:
        return len(self._at_forces)

    @cached_property
    def _at_forces(self) -> ResonanceCurve:
        return self.data.at_forces() if len(self.data) else self.data

    @property
    def force(self) -> NDArray[np.float64]:
        """(n,) [N]"""
        return self._at_forces.force

    @property
    def frequency(self) -> NDArray[np.float64]:
        """(n,) [Hz]"""
        return self._at_forces.frequency

    @property
    def receptance(self) -> NDArray[np.complex128]:
        """(n,) first harmonic over force [m/N]"""
        return self._at_forces.receptance

    @property
    def loss_factor(self) -> NDArray[np.float64]:
        """(n,) energy lost in a cycle over 2 pi times the largest energy stored"""
        return self._at_forces.loss_factor

    @property
    def complete(self) -> bool:
        """Whether the last force was reached; if not, `stopped` says why."""
        return self.data.complete

    @property
    def stopped(self) -> str:
        """Why it ended early, with what to try; "" where it did not."""
        return self.data.stopped

    @property
    def turned(self) -> NDArray[np.float64]:
        """(n,) forces near which it turned back in force on its way [N]. Where two resonances come near each other one
        may turn into the other: what was met after a turn need not be the resonance that it began as."""
        return self.data.force[np.flatnonzero(self.data.turning)]

    def plot(self) -> "NotebookFigure":
        """Frequency and receptance [mm/N] at resonance over force. Shows itself in a notebook; in a script save it:
        resonance.plot().savefig("resonance.png")
        """
        from updamp.pictures.curves import resonance_figure  # on call: matplotlib takes 0.5 s to load

        return resonance_figure(self.data)

    def __repr__(self) -> str:
        how = "complete" if self.complete else f"stopped: {self.stopped}"
        if len(self.turned):
            at = ", ".join(f"{force:.4g}" for force in self.turned[:_TURNS])
            how += f"; turned back in force near {at} N: what follows may be another resonance"
        ends = " to ".join(f"{self.frequency[i]:.2f} Hz at {self.force[i]:g} N" for i in (0, -1) if len(self))
        return f"<Resonance {self.data.mode} at {self.data.point}: {ends or 'no point'}, {how}>"

    def _repr_html_(self) -> str:
        head = ("Force [N]", "Frequency [Hz]", "Receptance [mm/N]", "Loss factor", "Contacts that slip or open")
        moving = self._at_forces.states[:, ContactState.STICK_SLIP :].sum(axis=1) if len(self) else ()
        columns = (self.force, self.frequency, MM * np.abs(self.receptance), self.loss_factor)
        rows = [(*(number(float(value), 5) for value in row), str(n)) for *row, n in zip(*columns, moving, strict=True)]
        title = f"{self.data.mode} at {self.data.point}"
        return table(head, rows, escape(f"{title}. {self.stopped}" if self.stopped else title), numbers_from=0)
