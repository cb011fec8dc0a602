"""The tests that the benchmark makes of a rig: an easy one, one of a rig that jumps, and one with few data."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

from updamp.benchmarks.virtual_rig.measurement import RIG
from updamp.benchmarks.virtual_rig.periodic import SolverOptions
from updamp.benchmarks.virtual_rig.plan import SIX_CURVES, NoiseLevels, PlannedRun, TestPlan


@dataclass(frozen=True)
class KindOfTest:
    """rig: its file, which the diagnosis is given and the laboratory measures with something hidden in it
    solver: of the laboratory, with as many harmonics as settle the peaks
    """

    name: str
    rig: Path
    plan: TestPlan
    noise: NoiseLevels
    solver: SolverOptions = field(default_factory=SolverOptions)


def _runs(ip: tuple[float, ...], oop: tuple[float, ...], upwards: bool = False) -> tuple[PlannedRun, ...]:
    return tuple(PlannedRun(mode, force, upwards) for mode, forces in (("IP", ip), ("OOP", oop)) for force in forces)


# Nothing jumps, three assemblies, all that the fit may need.
EASY = KindOfTest("easy", RIG, TestPlan(SIX_CURVES, assemblies=3, points=40), NoiseLevels())
# The reference rig with uniform pressure, each mode at a level at which contacts stick and two at which they do not: in
# IP they open before they slip and the response jumps, upwards elsewhere than downwards; in OOP they slip.
JUMPING = KindOfTest(
    "jumping",
    RIG.with_name("virtual_rig_jumping.toml"),
    TestPlan((*_runs((4.0, 8.0, 17.0), (8.0, 17.0, 34.0)), *_runs((17.0,), (34.0,), True)), assemblies=3, points=40),
    NoiseLevels(),
    SolverOptions(harmonics=11),
)
# What there is time for at the end of a test campaign: one assembly, two levels of each mode, few points, more noise.
SCARCE = KindOfTest(
    "scarce",
    RIG,
    TestPlan(_runs((2.0, 8.0), (4.0, 32.0)), assemblies=1, points=15),
    NoiseLevels(relative=0.015),
)
KINDS_OF_TEST: Mapping[str, KindOfTest] = MappingProxyType({kind.name: kind for kind in (EASY, JUMPING, SCARCE)})
