"""What the accuracy of harmonic balance depends on: harmonics, time samples, hysteresis cycles."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.system import NonlinearSystem

FURTHER_ORDERS = 4  # that the harmonics of an error estimate reach beyond the highest


@dataclass(frozen=True)
class Setting:
    """orders: harmonics kept; time_samples: a period; cycles: marched by laws with history, None where none has any

    raises: ValueError where the samples cannot resolve the harmonics, or there is no cycle
    """

    orders: tuple[int, ...]
    time_samples: int
    cycles: int | None = None

    def __post_init__(self) -> None:
        Harmonics(self.orders).analysis(self.time_samples)
        if self.cycles is not None and self.cycles < 1:
            raise ValueError(f"cycles = {self.cycles}: at least 1")

    def __str__(self) -> str:
        cycles = "" if self.cycles is None else f", {self.cycles} cycles"
        return f"harmonics {', '.join(map(str, self.orders))}, {self.time_samples} time samples{cycles}"


Refinement = Callable[[Setting], Setting]


def more_harmonics(setting: Setting, further: int = FURTHER_ORDERS) -> Setting:
    """Orders continued in the step of the last two (all, or odd ones only), up to `further` beyond the highest; samples
    raised where those need it. What finer harmonics are, here and in the numerical gate of comparisons."""
    orders = setting.orders
    step = orders[-1] - orders[-2] if len(orders) > 1 else 1
    orders += tuple(range(orders[-1] + step, orders[-1] + further + 1, step))
    return replace(setting, orders=orders, time_samples=max(setting.time_samples, 4 * orders[-1]))


def twice_the_samples(setting: Setting) -> Setting:
    return replace(setting, time_samples=2 * setting.time_samples)


def one_more_cycle(setting: Setting) -> Setting:
    """The same setting where no law has cycles."""
    return setting if setting.cycles is None else replace(setting, cycles=setting.cycles + 1)


def setting_of(system: NonlinearSystem) -> Setting:
    """The least of the cycles where laws differ."""
    cycles = [group.law.cycles for group in system.groups if hasattr(group.law, "cycles")]
    return Setting(system.harmonics.orders, system.time_samples, min(cycles) if cycles else None)


def with_setting(system: NonlinearSystem, setting: Setting) -> NonlinearSystem:
    """The same problem at another setting: laws with `cycles` are given the setting's."""
    groups = tuple(replace(group, law=_with_cycles(group.law, setting.cycles)) for group in system.groups)
    return replace(system, groups=groups, harmonics=Harmonics(setting.orders), time_samples=setting.time_samples)


def _with_cycles(law: Any, cycles: int | None) -> Any:
    return replace(law, cycles=cycles) if cycles is not None and hasattr(law, "cycles") else law
