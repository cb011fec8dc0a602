"""What is to be measured, and how far the laboratory is from perfect."""

from dataclasses import dataclass


@dataclass(frozen=True)
class PlannedRun:
    """mode: of the rig file's study; force: held [N]"""

    mode: str
    force: float
    upwards: bool = False

    @property
    def name(self) -> str:
        return f"{self.mode} {self.force:g} N" + (" up" if self.upwards else "")


SIX_CURVES = tuple(
    PlannedRun(mode, force)
    for mode, forces in (("IP", (2.0, 5.0, 8.0)), ("OOP", (4.0, 16.0, 32.0)))
    for force in forces
)
# Name of the channel in the files -> point of the rig.
TIPS = {"tip_left": "blade_left.tip.x", "tip_right": "blade_right.tip.x"}
CORNERS = {"corner_left_y": "damper.corner_left.y", "corner_right_y": "damper.corner_right.y"}


@dataclass(frozen=True)
class TestPlan:
    """assemblies: how often the damper is taken out and put back, all runs being made each time
    points: of a run; reach: to either side of the resonance, in its half-widths at 1/sqrt(2) of the peak
    corners: whether the damper's corners are measured too; harmonics: recorded; uff: whether UFF58 is written too
    """

    runs: tuple[PlannedRun, ...] = SIX_CURVES
    assemblies: int = 3
    points: int = 40
    reach: float = 5.0
    corners: bool = False
    harmonics: tuple[int, ...] = (1,)
    uff: bool = False

    __test__ = False  # for pytest, which takes the name for a test

    def __post_init__(self) -> None:
        for name, least in (("assemblies", 1), ("points", 8)):
            if getattr(self, name) < least:
                raise ValueError(f"TestPlan.{name} = {getattr(self, name)} must be at least {least}")
        if not self.runs or len({run.name for run in self.runs}) < len(self.runs):
            raise ValueError("TestPlan.runs: at least one is needed, each of its own mode, force and direction")

    def place(self, run: PlannedRun) -> float:
        """Among the runs of an assembly, which are made in this order: from -1/2 for the first to 1/2 for the last."""
        return self.runs.index(run) / max(len(self.runs) - 1, 1) - 0.5

    @property
    def channels(self) -> dict[str, str]:
        return TIPS | (CORNERS if self.corners else {})


@dataclass(frozen=True)
class NoiseLevels:
    """Standard deviations, relative where no unit is given.

    Sensors: relative, floor [m]: of the real and of the imaginary part; gain: of each channel and assembly;
    force_reading: of the force as recorded; force_control: of the force held, which the record shows
    Assemblies: friction, tangential, normal: mu, kt, kn; preload: of all normal forces; youngs_modulus
    Runs: drift: of all frequencies from run to run; ramp: share of the drift that goes on within a run
    """

    relative: float = 0.003
    floor: float = 1e-9
    gain: float = 0.01
    force_reading: float = 0.001
    force_control: float = 0.003
    friction: float = 0.03
    tangential: float = 0.02
    normal: float = 0.02
    preload: float = 0.01
    youngs_modulus: float = 1e-4
    drift: float = 3e-5
    ramp: float = 0.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 0 <= value < 1:
                raise ValueError(f"NoiseLevels.{name} = {value} must lie between 0 and 1")


QUIET = NoiseLevels(*[0.0] * 12)
