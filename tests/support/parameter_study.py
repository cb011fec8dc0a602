"""A parameter study on the coarsest mesh: three curves of two variants."""

from pathlib import Path

from rich.console import Console
from support.plain_rig import TINY_PRESET

from updamp.parameter_study.run_study import StudyRun, run_parameter_study
from updamp.parameter_study.study_file import read_parameter_study
from updamp.workflow.progress import Display

RIG = Path(__file__).parents[1] / "data" / "early_opening.toml"

STUDY = """
[study]
rig = "rig.toml"
mesh = "tiny"
out = "out"
findings = "pesaresi2017"

[[variants]]
name = "film"

[[variants]]
name = "50/50"
changes = { "contact.pressure" = { model = "uniform" } }

[[families]]
name = "levels"
title = "Levels"
variants = ["film", "50/50"]
modes = ["OOP"]
forces = ["0.096 N", "0.96 N"]
pictures = [
    "responses", "against_test", "peaks_against_force", "damper_motion", "contact_states", "force_loops",
    "mean_position", "pressure",
]

[contacts]
A1 = { face = "right", up = 1.0, along = 0.0 }
A2 = { face = "right", up = 0.0, along = 0.0 }

[[measured]]
mode = "OOP"
force = "0.096 N"
resonance = "435.9 Hz"
"""


def study_folder(folder: Path, text: str = STUDY) -> Path:
    """Returns: the study file"""
    (folder / "rig.toml").write_text(RIG.read_text() + TINY_PRESET)
    (folder / "study.toml").write_text(text)
    return folder / "study.toml"


def run(file: Path, solve: bool = True) -> StudyRun:
    study = read_parameter_study(file)
    with Display(Console(quiet=True)) as display:
        return run_parameter_study(study, study.out, 1, display, solve)
