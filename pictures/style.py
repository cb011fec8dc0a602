"""How all pictures look: one palette that the colour-blind can tell apart, one set of sizes, units on every axis."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

# Okabe and Ito (2008)
BLUE, ORANGE, GREEN, VERMILLION, SKY, YELLOW = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#56B4E9", "#F0E442"
GREY, LIGHT_GREY, INK = "#8A8F98", "#DADDE2", "#22262E"
LEFT_FACE, RIGHT_FACE = BLUE, ORANGE
STEEL, DARK_STEEL = "#C3C8D0", "#7D8592"
SEQUENTIAL: Final = "cividis"
DPI = 110
COLOURS = 160

_RC: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 9.5,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelcolor": INK,
    "axes.edgecolor": GREY,
    "axes.linewidth": 0.8,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": LIGHT_GREY,
    "grid.linewidth": 0.6,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "lines.linewidth": 1.6,
    "legend.frameon": False,
    "figure.facecolor": "white",
    "figure.constrained_layout.use": True,
}


@contextmanager
def figure(path: Path, width: float, height: float) -> Iterator[Figure]:
    """A figure of so many inches, saved to `path` as PNG when what is inside has drawn it."""
    with mpl.rc_context(_RC):
        drawing = Figure(figsize=(width, height))
        yield drawing
        write_png(Image.open(BytesIO(_png(drawing))).convert("RGB"), path)


class NotebookFigure(Figure):
    """A figure that a notebook shows by itself. Made without pyplot: the backend that the user has chosen stays."""

    def _repr_png_(self) -> bytes:
        return _png(self)


@contextmanager
def notebook_figure(
    width: float, height: float, rows: int, columns: int = 1, share: bool = False
) -> Iterator[tuple[NotebookFigure, list[Axes]]]:
    """A figure of so many inches and its axes by rows, for what is inside to draw; to be shown, or saved (`savefig`).

    share: whether all axes have one x
    """
    with mpl.rc_context(_RC):
        drawing = NotebookFigure(figsize=(width, height))
        yield drawing, list(drawing.subplots(rows, columns, sharex=share, squeeze=False).ravel())


def _png(drawing: Figure) -> bytes:
    buffer = BytesIO()
    drawing.savefig(buffer, dpi=DPI, format="png")
    return buffer.getvalue()


def write_png(picture: Image.Image, path: Path) -> None:
    """With few colours: a third of the size, and it looks the same."""
    path.parent.mkdir(parents=True, exist_ok=True)
    picture.quantize(COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(path, optimize=True)


def shades(count: int) -> Sequence[Any]:
    """So many colours from dark to light, the lightest still visible on white."""
    return [colormaps[SEQUENTIAL](0.92 * i / max(count - 1, 1)) for i in range(count)]
