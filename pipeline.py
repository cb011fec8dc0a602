"""The command line: `updamp init`, `run`, `compare`, `check`, `show`, `diagnose`, `add`, `remove`, `history`, `design`,
`design-rig`, `explain`, `study`.

What each command does is in `commands/`.
"""

from importlib.metadata import version
from typing import Annotated

import typer

from updamp.commands.compare import compare
from updamp.commands.design import design, design_rig, explain
from updamp.commands.effects import add, diagnose, history, remove
from updamp.commands.init import init
from updamp.commands.predict import check, run, show
from updamp.commands.study import study

app = typer.Typer(
    help="From a bladed test rig's dimensions to its nonlinear vibration with a friction damper.",
    no_args_is_help=True,
    rich_markup_mode=None,  # plain help: full names of options at 80 columns
    pretty_exceptions_enable=False,
)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"updamp {version('updamp')}")
        raise typer.Exit


@app.callback()
def main(
    _: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and end.")
    ] = False,
) -> None:
    pass


for command in (init, run, compare, check, show, diagnose, add, remove, history, design, design_rig, explain, study):
    app.command()(command)


if __name__ == "__main__":
    app()
