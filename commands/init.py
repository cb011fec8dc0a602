"""The command that begins: `updamp init`."""

import shlex
import shutil
import sys
from importlib.resources import files
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from updamp.commands.shared import Debug, clean_errors, named_path

FILES = ("rig.toml", "measurement.toml", "sweeps.csv", "sealed.json")
# What to try, and what it does; times of two processors to themselves.
STEPS = (
    ("updamp check rig.toml", "what the rig file says, in SI; memory and time of its meshes"),
    ("updamp run rig.toml --out prediction", "responses at two forces; look into prediction/pictures"),
    (
        'updamp diagnose rig.toml measurement.toml --out found --hold-out "IP 5 N" --hold-out "OOP 16 N"',
        "which effect the model lacks, judged on two runs that no fit has seen: found/report.html",
    ),
    ("updamp add rig.toml --from found --out better.toml", "a rig file with that effect"),
    ("updamp compare better.toml measurement.toml --out after", "does it describe the test now? after/report.html"),
)


def init(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", parser=named_path, help="New folder.")],
    debug: Debug = False,
) -> None:
    """Write an example into a folder: a rig, a test of it with a hidden effect, and five commands to try.

    The test was made by a virtual laboratory that shares no code with the model; sealed.json says what is hidden.
    """
    with clean_errors(debug):
        if there := [name for name in FILES if (folder / name).exists()]:
            raise ValueError(f"{folder}: has {', '.join(there)} already; give another folder")
        write_example(folder)
        console = Console()
        console.print(f"{folder} is made. In it, one after the other:", highlight=False)
        first = [(command, "") for command in (*activation(), f"cd {shlex.quote(str(folder))}")]
        for command, purpose in (*first, *STEPS):
            console.print(f"  {command}", highlight=False, soft_wrap=True)
            if purpose:
                console.print(f"      {purpose}", style="dim", highlight=False, soft_wrap=True)


def activation() -> tuple[str, ...]:
    """What lets a shell find `updamp`, where this one does not: it was called by its path, from an environment."""
    script = Path(sys.prefix) / "bin" / "activate"
    return () if shutil.which("updamp") or not script.is_file() else (f"source {shlex.quote(str(script))}",)


def write_example(folder: Path) -> None:
    """Those files, and the steps as README.md. raises: OSError"""
    folder.mkdir(parents=True, exist_ok=True)
    source = files("updamp.commands.example")
    for name in FILES:
        (folder / name).write_bytes((source / name).read_bytes())
    steps = "\n".join(f"{i}. `{command}`  \n   {purpose}" for i, (command, purpose) in enumerate(STEPS, 1))
    (folder / "README.md").write_text(
        "# A first rig\n\n"
        "`rig.toml` describes two blades with a friction damper; `measurement.toml` and `sweeps.csv` are a test of it. "
        "The test has an effect that the model lacks. Which one, is in `sealed.json`: open it last.\n\n"
        f"{steps}\n",
        encoding="utf-8",
    )
