"""What an error of an identified mode's shape at one sensor does to what that sensor reads."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
# Of an entry as stated, what the true one is taken to be at least: an entry of none has no mode to be seen in.
_LEAST = 0.1


@dataclass(frozen=True, eq=False)
class ShapeError:
    """entry: of the model's shape at the sensor, over the largest of the shape; share: (n,) complex, how much of what
    was measured the mode is, the rest being the other modes' response

    With the true entry a + b, b the error, the mode's part of a reading X is s X, of which the model has a / (a + b),
    so that X / X_model = 1 / (1 - s b / (a + b)).
    """

    entry: float
    share: NDArray[np.complex128]

    def moves(self, error: float) -> Floats:
        """(n, 2) of logarithm of amplitude and phase, reading less model"""
        return _two(-np.log(1 - self.share * error / self._true(error)))

    def slopes(self, error: float) -> Floats:
        """(n, 2) derivatives of it by the error"""
        true = self._true(error)
        return _two(self.share * self.entry / true**2 / (1 - self.share * error / true))

    def only(self, points: NDArray[np.bool_ | np.int64]) -> "ShapeError":
        return ShapeError(self.entry, self.share[points])

    def _true(self, error: float) -> float:
        least = _LEAST * abs(self.entry)
        return float(np.copysign(max(np.copysign(1, self.entry) * (self.entry + error), least), self.entry))


def _two(values: NDArray[np.complex128]) -> Floats:
    return np.stack([values.real, values.imag], axis=1)
