"""The reference rig on a mesh that is coarser still, with narrow windows: a run of it takes seconds."""

from collections.abc import Sequence
from pathlib import Path

from click.testing import Result
from typer.testing import CliRunner

from updamp.pipeline import app

RIG = Path(__file__).parents[1] / "data" / "early_opening.toml"
COARSE = """[mesh.small]
width = 6
face = 2
platform_outer = 1
platform_inner = 1
platform_height = 2
stem_thickness = 1
stem_below_excitation = 2
stem_below_platform = 1
stem_above_platform = 5
stem_top = 1
damper_across = 2
damper_apex = 1
damper_base = 1
contact_elements = 24
"""  # what a run writes does not depend on the mesh; its resonances are OOP 450 Hz and IP 439 Hz
STUCK = ("0.01 N",)  # no contact slips


def short_study(folder: Path, oop: tuple[float, float], ip: tuple[float, float], levels: Sequence[str] = STUCK) -> Path:
    """A rig file in the folder. oop, ip: windows [Hz]; levels: of the force"""
    head, _ = RIG.read_text(encoding="utf-8").split("[study]")
    forces = ", ".join(f'"{level}"' for level in levels)
    study = (
        f'[study]\nforce_levels = [{forces}]\n[study.modes.OOP]\nwindow = ["{oop[0]} Hz", "{oop[1]} Hz"]\n'
        f'[study.modes.IP]\nwindow = ["{ip[0]} Hz", "{ip[1]} Hz"]\n'
    )
    path = folder / "short.toml"
    path.write_text(f"{head}{study}\n{COARSE}", encoding="utf-8")
    return path


def run_command(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])
