"""What a run shows on the terminal: a bar for every stage and curve at work, a line for each that is done."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.text import Text

Update = Callable[[float, str], None]


KNOWN_FROM = 0.05  # share of the work from which on the time left can be told


class Display:
    """Context manager around rich's live display. Bars vanish when their work is done, lines stay.

    Where the output is not a terminal, only the lines are written. log: file that the lines are added to, with the time
    """

    def __init__(self, console: Console | None = None, log: Path | None = None) -> None:
        self.console, self.log = console or Console(), log
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
        self.forget(name)
        self._line(mark, style, f"{name:<16} {detail}")

    def _line(self, mark: str, style: str, text: str) -> None:
        self.console.print(Text.assemble((f"{mark:<10}", style), text), highlight=False, soft_wrap=True)
        if self.log is not None:
            with suppress(OSError), self.log.open("a", encoding="utf-8") as file:  # it is not worth failing for
                file.write(f"{datetime.now():%Y-%m-%d %H:%M:%S} {mark:<10}{text}\n")

    def begins(self, name: str) -> None:
        """A line about work that may take minutes, where no bar can be seen."""
        if not self.console.is_terminal:
            self._line("begins", "dim", name)

    def step(self, name: str, share: float, what: str) -> None:
        """The bar of work of which nobody knows how many steps it takes; a line for each where no bar can be seen."""
        self.update(name, share, what)
        if not self.console.is_terminal:
            self._line("at", "dim", f"{name:<16} {what}")

    def forget(self, name: str) -> None:
        """Take a bar away without a line."""
        if name in self._bars:
            self._progress.remove_task(self._bars.pop(name))

    def unchanged(self, name: str, stopped: str = "") -> None:
        """stopped: why the work ended early when it was done: that it is kept does not make it whole"""
        if stopped:
            self.failed(name, f"kept as it is on file: {stopped}")
        else:
            self.done(name, "", mark="unchanged", style="dim")

    def note(self, name: str, sentence: str) -> None:
        """A line that the user should read; the bar stays."""
        self._line("note", "yellow", f"{name:<16} {sentence}")

    def failed(self, name: str, detail: str) -> None:
        self.done(name, detail, mark="stopped", style="red")

    def together(self, name: str, of: int) -> "Together":
        """One bar for pieces of work that are done at the same time. of: how many"""
        return Together(self, name, of)

    @contextmanager
    def stage(self, name: str) -> Iterator[Update]:
        """A bar for the work inside; the update takes the share done and what is being done."""
        started = time.perf_counter()
        self.update(name, 0.0)
        yield lambda share, detail: self.update(name, share, detail)
        self.done(name, f"{time.perf_counter() - started:.1f} s")


class Together:
    """How far pieces of work are in all: the mean of their shares, and from it the time that is left."""

    def __init__(self, display: Display, name: str, of: int) -> None:
        self._display, self._name, self._of = display, name, of
        self._shares: dict[str, float] = {}
        self._done: set[str] = set()
        self._started = time.monotonic()
        self._show()

    def update(self, piece: str, share: float) -> None:
        if piece not in self._shares:
            self._display.begins(piece)
        self._shares[piece] = share
        self._show()

    def done(self, piece: str) -> None:
        """Whether it was finished or not."""
        self._shares[piece] = 1.0
        self._done.add(piece)
        self._show()

    def over(self) -> None:
        self._display.forget(self._name)

    @property
    def share(self) -> float:
        return sum(self._shares.values()) / self._of

    def _show(self) -> None:
        left = time_left(time.monotonic() - self._started, self.share)
        self._display.update(self._name, self.share, f"{len(self._done)} of {self._of} done{left}")


def time_left(elapsed: float, share: float) -> str:
    """In words, "" as long as it cannot be told. elapsed: [s] for the share done so far"""
    if not KNOWN_FROM <= share < 1:
        return ""
    seconds = elapsed * (1 - share) / share
    return f", about {seconds:.0f} s left" if seconds < 90 else f", about {seconds / 60:.0f} min left"
