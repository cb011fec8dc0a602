"""A curve of half a problem that is its own mirror image, and the curve of the whole."""

from dataclasses import dataclass, replace

from updamp.hbm.continuation.curve_records import CurveRequest
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.problem.mirror import Mirror
from updamp.hbm.problem.system import NonlinearSystem


@dataclass(frozen=True, eq=False)
class HalfProblem:
    """system, request: of the half (hbm/problem/mirror.py)"""

    system: NonlinearSystem
    request: CurveRequest
    mirror: Mirror

    @staticmethod
    def of(system: NonlinearSystem, request: CurveRequest) -> "HalfProblem | None":
        """None where the problem or its excitation is not its own mirror image."""
        row = request.excitation.row
        if (driven := system.half_driven_at(row)) is None:
            return None
        half, mirror = driven
        excitation = replace(request.excitation, row=row - system.free.n_relative + half.free.n_relative)
        return HalfProblem(half, replace(request, excitation=excitation), mirror)

    def halved(self, curve: ResponseCurve) -> ResponseCurve:
        displacement = self.mirror.halved(curve.displacement) if len(curve) else curve.displacement
        return replace(curve, displacement=displacement, detached=tuple(map(self.halved, curve.detached)))

    def whole(self, curve: ResponseCurve) -> ResponseCurve:
        displacement = self.mirror.whole(curve.displacement) if len(curve) else curve.displacement
        return replace(curve, displacement=displacement, detached=tuple(map(self.whole, curve.detached)))
