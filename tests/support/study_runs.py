"""Studies run in this process, without a terminal."""

from pathlib import Path

from rich.console import Console

from updamp.design.run_study import StudyResult, run_study
from updamp.design.study_file import read_study
from updamp.workflow.progress import Display


def run(path: Path, jobs: int = 1, out: Path | None = None, scheduler: str = "") -> StudyResult:
    study = read_study(path)
    with Display(Console(quiet=True)) as display:
        return run_study(study, out or study.out, jobs, scheduler, display)
