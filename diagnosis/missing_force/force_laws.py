"""Which law of amplitude a missing force follows, from its equations over all runs.

The missing stiffness and damping are sums of powers of the amplitude, k(A) = sum_j k_j (A / A_0)^j. Every choice of
powers is fitted by least squares, weighted with noise and scatter, while the calibration may be adjusted again within
what it was known to before: what a change of calibration imitates is not read as a force. Choices are weighed by the
Bayesian information criterion (G. Schwarz, Annals of Statistics 6 (1978) 461), BIC = chi2 + parameters ln(values).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Difference of BIC that counts as decisive (R. E. Kass and A. E. Raftery, J. Am. Stat. Assoc. 90 (1995) 773).
DECISIVE = 10.0
# Sweeps over the modes, each time with the choices of the others as they are.
_SWEEPS = 3
STIFFNESS, DAMPING, LEVELS = "stiffness", "damping", "levels"


@dataclass(frozen=True)
class PowerLaw:
    """A power of the amplitude, or none. free: whether the power was chosen by the data, which costs a parameter"""

    name: str
    power: float | None
    free: bool = False

    @property
    def cost(self) -> int:
        return 0 if self.power is None else 1 + self.free


NOTHING = PowerLaw("nothing", None)
CONSTANT, CUBIC = PowerLaw("constant", 0.0), PowerLaw("cubic", 2.0)
VISCOUS, QUADRATIC, COULOMB = PowerLaw("viscous", 0.0), PowerLaw("quadratic", 1.0), PowerLaw("Coulomb", -1.0)
_FALLING = tuple(PowerLaw("falling", p, free=True) for p in (-1.5, -0.75, -0.5, -0.25))
_RISING = tuple(PowerLaw("rising", p, free=True) for p in (0.25, 0.5, 0.75, 1.5))
OF_STIFFNESS = (
    NOTHING, CONSTANT, CUBIC, *_FALLING, PowerLaw("falling", -1.0, True), *_RISING, PowerLaw("rising", 1.0, True)
)  # fmt: skip
OF_DAMPING = (NOTHING, VISCOUS, QUADRATIC, COULOMB, *_FALLING, *_RISING, PowerLaw("rising", 2.0, True))
POWERS = {
    STIFFNESS: tuple(law.power for law in OF_STIFFNESS if law.power is not None),
    DAMPING: tuple(law.power for law in OF_DAMPING if law.power is not None),
}


@dataclass(frozen=True)
class Column:
    """An unknown of the equations: of a mode and quantity, either a power of the amplitude or (LEVELS) a piece of it"""

    mode: str
    quantity: str
    power: float = 0.0


@dataclass(frozen=True)
class LawPair:
    """Laws of one mode's missing force."""

    stiffness: PowerLaw = NOTHING
    damping: PowerLaw = NOTHING

    @property
    def cost(self) -> int:
        return self.stiffness.cost + self.damping.cost

    def columns(self, mode: str) -> list[Column]:
        pairs = ((STIFFNESS, self.stiffness), (DAMPING, self.damping))
        return [Column(mode, quantity, law.power) for quantity, law in pairs if law.power is not None]


@dataclass(frozen=True)
class FittedLaw:
    """A law with its size and standard deviation at the mode's largest amplitude

    alternatives: laws that BIC does not tell from it
    """

    law: PowerLaw
    size: float
    deviation: float
    alternatives: tuple[PowerLaw, ...]


@dataclass(frozen=True)
class ForceLaw:
    """simple: False where pieces of amplitude taken one by one fit decisively better than any law"""

    stiffness: FittedLaw
    damping: FittedLaw
    simple: bool


class Squares:
    """Least squares of subsets of the columns, from their products alone.

    residual: (n,) whitened; calibration: (n, p) whitened, with its prior (standard deviations (p,), inf for none) and
        where it stands now; columns: (n, c) whitened, of the unknowns in `names`
    """

    def __init__(
        self,
        residual: Floats,
        calibration: Floats,
        deviation: Floats,
        now: Floats,
        columns: Floats,
        names: Sequence[Column],
    ) -> None:
        scale = np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
        everything = np.hstack([calibration, columns / scale])
        self._products, self._right = everything.T @ everything, everything.T @ residual
        p = calibration.shape[1]
        self._products[:p, :p] += np.diag(deviation**-2.0)
        self._right[:p] -= now / deviation**2
        self._chi2, self._scale, self._p = float(residual @ residual + np.sum((now / deviation) ** 2)), scale, p
        self.values = len(residual)
        self._place: dict[Column, list[int]] = {}
        for i, name in enumerate(names):
            self._place.setdefault(name, []).append(i)
        pieces = [name for name in self._place if name.quantity == LEVELS]
        left = self.values - sum(len(self._place[name]) for name in pieces)
        # where not even free pieces bring chi2 down to the noise, the noise is what they leave (R. T. Birge, 1932)
        self.noise = max(1.0, self._solve(pieces)[2] / left)

    def bic(self, choices: Mapping[str, LawPair]) -> float:
        columns = [column for mode, choice in choices.items() for column in choice.columns(mode)]
        return self._solve(columns)[2] / self.noise + sum(c.cost for c in choices.values()) * np.log(self.values)

    def bic_in_pieces(self, choices: Mapping[str, LawPair], mode: str) -> float:
        """Like `bic`, with one mode's force free in every piece of amplitude."""
        rest = {name: choice for name, choice in choices.items() if name != mode}
        columns = [column for name, choice in rest.items() for column in choice.columns(name)]
        pieces = Column(mode, LEVELS)
        cost = len(self._place[pieces]) + sum(c.cost for c in rest.values())
        return self._solve([*columns, pieces])[2] / self.noise + cost * np.log(self.values)

    def sizes(self, choices: Mapping[str, LawPair]) -> dict[Column, tuple[float, float]]:
        """Value and standard deviation of every column chosen."""
        columns = [column for mode, choice in choices.items() for column in choice.columns(mode)]
        value, covariance, _ = self._solve(columns)
        deviation = np.sqrt(self.noise * np.diag(covariance))
        return {c: (float(v), float(d)) for c, v, d in zip(columns, value, deviation, strict=True)}

    def _solve(self, columns: Sequence[Column]) -> tuple[Floats, Floats, float]:
        wanted = [i for column in columns for i in self._place[column]]
        index = np.array([*range(self._p), *(self._p + i for i in wanted)], dtype=np.int64)
        inverse = np.linalg.pinv(self._products[np.ix_(index, index)], rcond=1e-12, hermitian=True)
        solution = inverse @ self._right[index]
        chi2 = self._chi2 - float(self._right[index] @ solution)
        scale = self._scale[wanted]
        covariance = inverse[self._p :, self._p :] / np.outer(scale, scale)
        return solution[self._p :] / scale, covariance, chi2


def force_laws(squares: Squares, modes: Sequence[str]) -> dict[str, ForceLaw]:
    """Of every mode's missing force; a law is only claimed where leaving it out costs decisively."""
    choices = {mode: LawPair() for mode in modes}
    for _ in range(_SWEEPS):
        before = dict(choices)
        for mode in modes:
            tried = [LawPair(k, c) for k, c in product(OF_STIFFNESS, OF_DAMPING)]
            best = min(tried, key=lambda choice: squares.bic({**choices, mode: choice}))
            choices[mode] = _claimed(squares, choices, mode, best)
        if choices == before:
            break
    sizes = squares.sizes(choices)
    return {mode: _force_law(squares, choices, mode, sizes) for mode in modes}


def _claimed(squares: Squares, choices: Mapping[str, LawPair], mode: str, best: LawPair) -> LawPair:
    """Without laws that hardly pay."""
    bic = {
        c: squares.bic({**choices, mode: c})
        for c in (LawPair(), LawPair(best.stiffness), LawPair(NOTHING, best.damping))
    }
    enough = squares.bic({**choices, mode: best}) + DECISIVE
    if bic[LawPair()] < enough:
        return LawPair()
    simplest = min(bic, key=lambda choice: bic[choice])
    return simplest if bic[simplest] < enough else best


def _force_law(
    squares: Squares, choices: Mapping[str, LawPair], mode: str, sizes: Mapping[Column, tuple[float, float]]
) -> ForceLaw:
    choice = choices[mode]
    bic = squares.bic(choices)

    def alternatives(laws: Sequence[PowerLaw], others: Sequence[LawPair], own: PowerLaw) -> tuple[PowerLaw, ...]:
        if own is NOTHING:
            return ()
        close = [
            law
            for law, other in zip(laws, others, strict=True)
            if law.name != own.name and squares.bic({**choices, mode: other}) < bic + DECISIVE
        ]
        return tuple({law.name: law for law in close}.values())

    of_stiffness = alternatives(OF_STIFFNESS, [LawPair(law, choice.damping) for law in OF_STIFFNESS], choice.stiffness)
    of_damping = alternatives(OF_DAMPING, [LawPair(choice.stiffness, law) for law in OF_DAMPING], choice.damping)
    return ForceLaw(
        _term(choice.stiffness, mode, STIFFNESS, sizes, of_stiffness),
        _term(choice.damping, mode, DAMPING, sizes, of_damping),
        squares.bic_in_pieces(choices, mode) > bic - DECISIVE,
    )


def _term(
    law: PowerLaw,
    mode: str,
    quantity: str,
    sizes: Mapping[Column, tuple[float, float]],
    alternatives: tuple[PowerLaw, ...],
) -> FittedLaw:
    size, deviation = (0.0, 0.0) if law.power is None else sizes[Column(mode, quantity, law.power)]
    return FittedLaw(law, size, deviation, alternatives)
