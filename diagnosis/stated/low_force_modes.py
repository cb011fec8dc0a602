"""The study's modes at small force, known by their shapes however far an explanation moves them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from updamp.comparison.findings.stated_values import WITHOUT_DAMPER
from updamp.effects.rig_model import RigModel
from updamp.hbm.problem.small_amplitude import SmallAmplitude
from updamp.model.small_amplitude import settled, small_amplitude, without_contacts

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

_LOOKED_AT = 8  # lowest modes among which the study's are sought
_OTHERS = 2  # modes above the study's that are followed too
_LEAST_MOTION = 1e-3  # of the tip in such a mode, as a share of that in the study's


@dataclass(frozen=True, eq=False)
class LowForceModes:
    """windows: of the study's modes [Hz]; shapes: of each mode at the model's points (n_points,), as given
    near: frequencies as given [Hz]; component: whose first frequency is that without damper
    others: names of modes above the study's, which are followed too
    """

    windows: Mapping[str, tuple[float, float]]
    shapes: Mapping[str, Complex]
    near: Mapping[str, float]
    component: str
    others: tuple[str, ...] = ()

    def frequencies(self, model: RigModel, names: Sequence[str]) -> Floats:
        """[Hz]; names: of the study, or ending in "without damper" """
        coupled = [name for name in names if WITHOUT_DAMPER not in name]
        found = {name: float(s.frequencies[i]) for name, (s, i) in self.solved(model, coupled).items()}
        alone = without_contacts(model, self.component) if len(coupled) < len(names) else float("nan")
        return np.array([found.get(name, alone) for name in names])

    def solved(self, model: RigModel, names: Sequence[str]) -> dict[str, tuple[SmallAmplitude, int]]:
        """Name -> solution and number of the mode in it."""
        if not names:
            return {}
        return settled(model, {name: self.near[name] for name in names}, self._places)

    def _places(self, found: SmallAmplitude) -> dict[str, int]:
        """Each mode's most alike, none of them twice."""
        names = tuple(self.shapes)
        n = found.free.n_relative
        shapes = found.shapes[n : n + len(self.shapes[names[0]]), :_LOOKED_AT]
        alike = np.array([[_mac(self.shapes[name], shapes[:, i]) for i in range(shapes.shape[1])] for name in names])
        return {names[i]: int(j) for i, j in zip(*linear_sum_assignment(-alike), strict=True)}


def low_force_modes(model: RigModel, windows: Mapping[str, tuple[float, float]], component: str) -> LowForceModes:
    """raises: ValueError where no mode of the model lies in a window"""
    found = small_amplitude(model, float(np.mean([np.mean(w) for w in windows.values()])))
    points = slice(found.free.n_relative, found.free.n_rows)
    tip = f"{component}.tip.x"
    shapes, near = {}, {}
    for name, (low, high) in windows.items():
        inside = np.flatnonzero((found.frequencies > low) & (found.frequencies < high))
        if not len(inside):
            raise ValueError(
                f"mode {name}: the model has none from {low:g} to {high:g} Hz, where the study looks for it; it has "
                f"{', '.join(f'{f:.1f}' for f in found.frequencies[:4])} Hz. Widen study.modes.{name}.window"
            )
        mode = max((int(i) for i in inside), key=lambda i: found.peak(tip, model.excitation, i))
        shapes[name], near[name] = found.shapes[points, mode], float(found.frequencies[mode])
    others: list[str] = []
    of_study = min(abs(found.at(tip, int(np.argmin(abs(found.frequencies - f))))) for f in near.values())
    for i in np.flatnonzero(found.frequencies > max(near.values()) * (1 + 1e-9))[: 4 * _OTHERS]:
        # one that hardly moves the tip is not seen in a test, and has no shape to be known by
        if len(others) < _OTHERS and abs(found.at(tip, int(i))) > _LEAST_MOTION * of_study:
            others.append(f"mode {i + 1}")
            shapes[others[-1]], near[others[-1]] = found.shapes[points, i], float(found.frequencies[i])
    return LowForceModes(windows, shapes, near, component, tuple(others))


def _mac(a: Complex, b: Complex) -> float:
    """Modal assurance criterion."""
    return float(abs(np.vdot(a, b)) ** 2 / (np.vdot(a, a).real * np.vdot(b, b).real))
