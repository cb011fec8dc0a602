"""What a run shows on the terminal: a bar for every stage and curve at work, a line for each that is done."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.text import Text

Update = Callable[[float, str], None]


class Display:
    """Context manager around rich's live display. Bars vanish when their work is done, lines stay.

    Where the output is not a terminal, only the lines are written.
    """

    def __init__(self, console: Console | None = None) -> None:
        self.console = console or Console()
        self._progress = Progress(
            SpinnerColumn(),
            TextColumn("{task.description:<18}"),
            BarColumn(bar_width=30),
            TextColumn("{task.percentage:>3.0f} %"),
            TimeElapsedColumn(),
            TextColumn("{task.fields[detail]}", style="dim"),
            console=self.console,
            transient=True,
        )
        self._bars: dict[str, TaskID] = {}

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._progress.stop()

    def update(self, name: str, share: float, detail: str = "") -> None:
        """Move the bar `name` to a share from 0 to 1; it appears with its first update."""
        if name not in self._bars:
            self._bars[name] = self._progress.add_task(name, total=1.0, detail="")
        self._progress.update(self._bars[name], completed=share, detail=detail)

    def done(self, name: str, detail: str, mark: str = "done", style: str = "green") -> None:
        """Replace the bar by a line."""
        if name in self._bars:
            self._progress.remove_task(self._bars.pop(name))
        line = Text.assemble((f"{mark:<10}", style), f"{name:<16} {detail}")
        self.console.print(line, highlight=False, soft_wrap=True)

    def unchanged(self, name: str, detail: str = "") -> None:
        self.done(name, detail, mark="unchanged", style="dim")

    def note(self, name: str, sentence: str) -> None:
        """A line that the user should read; the bar stays."""
        line = Text.assemble((f"{'note':<10}", "yellow"), f"{name:<16} {sentence}")
        self.console.print(line, highlight=False, soft_wrap=True)

    def failed(self, name: str, detail: str) -> None:
        self.done(name, detail, mark="stopped", style="red")

    @contextmanager
    def stage(self, name: str) -> Iterator[Update]:
        """A bar for the work inside; the update takes the share done and what is being done."""
        started = time.perf_counter()
        self.update(name, 0.0)
        yield lambda share, detail: self.update(name, share, detail)
        self.done(name, f"{time.perf_counter() - started:.1f} s")
