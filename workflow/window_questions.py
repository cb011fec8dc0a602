"""Is there a resonance in the windows of the study? Asked once the structure's frequencies are known, before any curve.

With friction a resonance lies between that of the blade alone, as if all contacts slipped freely, and that of the
structure whose contacts all stick: less stiffness never raises a frequency (Rayleigh).
"""

from collections.abc import Mapping, Sequence

import numpy as np

Range = tuple[float, float]


def possible_resonances(free: Sequence[float], stuck: Sequence[float]) -> list[Range]:
    """(lowest, highest) frequency of each stuck mode's resonance [Hz].

    free: frequencies of the blades alone; stuck: of the structure with all contacts stuck
    """
    return [(float(max((f for f in free if f <= top), default=top)), float(top)) for top in stuck]


def empty_windows(windows: Mapping[str, Range], resonances: Sequence[Range], known_up_to: float) -> list[str]:
    """A question for each window below `known_up_to` [Hz] that no resonance can lie in.

    windows: mode -> (lower, upper) [Hz]; resonances: as `possible_resonances` has them
    """
    return [
        f"study.modes.{mode}.window = {low:g} to {high:g} Hz: no resonance of this mesh can lie there, the nearest are "
        f"{_listed(resonances, (low + high) / 2)}; is another window meant?"
        for mode, (low, high) in windows.items()
        if low < known_up_to and not any(low <= top and bottom <= high for bottom, top in resonances)
    ]


def _listed(resonances: Sequence[Range], middle: float) -> str:
    nearest = sorted(resonances, key=lambda one: abs(np.log(one[1] / middle)))[:2]
    return " and ".join(
        f"at {low:.0f} to {high:.0f} Hz" if high - low > 1 else f"at {high:.1f} Hz" for low, high in nearest
    )
