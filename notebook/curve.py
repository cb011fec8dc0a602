"""A response curve that shows itself."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.report.markup import number, table

if TYPE_CHECKING:
    from updamp.pictures.style import NotebookFigure

MM = 1e3  # m to mm


@dataclass(frozen=True, eq=False, repr=False)
class Curve:
    """Periodic responses at constant force, turning points included, in the order of the branch.

    data: all that is known of every point (`hbm/continuation/response_curve.py`); points: names of those shown
    """

    data: ResponseCurve
    points: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.data)

    @property
    def mode(self) -> str:
        return self.data.mode

    @property
    def force(self) -> float:
        """Amplitude of the excitation [N]"""
        return self.data.force

    @property
    def frequency(self) -> NDArray[np.float64]:
        """(n,) [Hz]; neither rising nor falling throughout where the branch turns round"""
        return self.data.frequency

    @property
    def complete(self) -> bool:
        """Whether the branch was followed through the whole window; if not, `stopped` says why."""
        return self.data.complete

    @property
    def stopped(self) -> str:
        """Where the branch was not followed and why, with what to try; "" where it was."""
        return self.data.stopped

    def receptance(self, point: str | None = None) -> NDArray[np.complex128]:
        """(n,) first harmonic of the displacement over the force [m/N]

        point: the first one shown by default; raises: ValueError naming the points there are
        """
        return self.data.receptance(point or self.points[0])

    def amplitude(self, point: str | None = None, harmonic: int = 1) -> NDArray[np.complex128]:
        """(n,) complex amplitude of a harmonic of the displacement [m]; point, raises: as for `receptance`"""
        return self.data.amplitude(point or self.points[0], harmonic)

    def peak(self, point: str | None = None) -> tuple[float, float]:
        """Frequency [Hz] and size of the receptance [m/N] where it is largest; point, raises: as for `receptance`"""
        return self.data.peak(point or self.points[0])

    def plot(self, *others: "Curve", points: Sequence[str] | None = None) -> "NotebookFigure":
        """Amplitude [mm/N] and phase of the receptance over frequency, together with those of other curves.

        points: names of those drawn, by default those shown. The figure shows itself in a notebook; in a script save
        it: curve.plot().savefig("curve.png")
        """
        from updamp.pictures.curves import receptance_figure  # on call: matplotlib takes 0.5 s to load

        return receptance_figure([(one.data, p) for one in (self, *others) for p in points or one.points])

    def __repr__(self) -> str:
        at, top = self.peak() if len(self) else (np.nan, np.nan)
        how = "complete" if self.complete else f"stopped: {self.stopped}"
        return (
            f"<Curve {self.mode}, {self.force:g} N: {len(self)} points, peak {MM * top:.5g} mm/N at {at:.2f} Hz, {how}>"
        )

    def _repr_html_(self) -> str:
        head = ("Mode", "Point", "Force [N]", "Peak [Hz]", "Peak [mm/N]", "Points")
        rows = [(escape(self.mode), escape(point), *self._numbers(point)) for point in self.points]
        return table(head, rows if len(self) else [], escape(self.stopped), numbers_from=2)

    def _numbers(self, point: str) -> tuple[str, ...]:
        at, top = self.peak(point)
        return f"{self.force:g}", number(at, 6), number(MM * top), str(len(self))
