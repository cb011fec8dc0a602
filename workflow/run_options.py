"""What a run is asked for."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from updamp.parallel.resources import checked_workers
from updamp.workflow.stages import Stage


@dataclass(frozen=True)
class RunOptions:
    """preset: of the mesh; folder: for all that the run writes; workers: processes that trace curves

    modes, forces: which curves [N]; empty for all of the study
    stability: whether to say of every point whether it is stable
    accuracy: whether to trace every curve again with more harmonics, to state its numerical error; what fails of that
        is not known, and the curve is no less complete
    marching: whether to march a few periods in time from every curve's peak, to see whether the motion stays
    resonance: whether to follow every mode's resonance in the force, through all levels of the study
    quick: whether to compute only what a first look at the responses needs (`quick_look.py`); what is on file is taken
    check: whether to compare the reduced with the full coupled model; until: last stage, None for all
    raises: ValueError naming the option that is out of range
    """

    preset: str
    folder: Path
    workers: int = 1
    modes: tuple[str, ...] = ()
    forces: tuple[float, ...] = ()
    check: bool = True
    pictures: bool = True
    accuracy: bool = False
    stability: bool = False
    marching: bool = False
    resonance: bool = False
    quick: bool = False
    until: Stage | None = None

    def __post_init__(self) -> None:
        checked_workers(self.workers)

    def part(self, modes: Sequence[str]) -> str:
        """A sentence on which curves of a study the run has, where it was asked for a part; "" where it has all.

        modes: of the study
        """
        names = [option for option, given in (("--mode", self.modes), ("--force", self.forces)) if given]
        if not names:
            return ""
        forces = f" at {', '.join(f'{force:g}' for force in sorted(self.forces))} N" if self.forces else ""
        return (
            f"asked for with {' and '.join(names)}: summary.json and the response files that were written now have "
            f"{', '.join(self.modes or modes)}{forces} alone; other files here, pictures that were not drawn now too, "
            f"are of earlier runs. Without {' and '.join(names)} the run has all of the study"
        )
