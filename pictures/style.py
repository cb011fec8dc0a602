"""How all pictures look: what pictures/updamp.mplstyle says, and over it the style file of the user's own."""

import hashlib
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
from matplotlib import colormaps, rc_params_from_file
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from PIL import Image

from updamp.parallel.whole_file import written_to

OWN_STYLE: Final = "UPDAMP_STYLE"  # in the environment: a matplotlib style file
FORMATS: Final = (".svg", ".pdf")  # written beside every PNG, for documents and papers
COLOURS = 160
_STYLE = Path(__file__).with_name("updamp.mplstyle")
_DATES: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}  # none: equal results, equal files


def _read() -> Any:
    """raises: ValueError where the user's own file is missing"""
    found: dict[Any, Any] = dict(rc_params_from_file(_STYLE, use_default_template=False))
    if own := os.environ.get(OWN_STYLE, ""):
        if not Path(own).is_file():
            raise ValueError(f"{OWN_STYLE}={own}: there is no such file; it is to be a matplotlib style file")
        found.update(rc_params_from_file(own, use_default_template=False))
    return found


_RC = _read()


def _categories(count: int) -> Sequence[str]:
    """So many colours, from the beginning again where the style has fewer."""
    there = [to_hex(one["color"]) for one in _RC["axes.prop_cycle"]]
    return [there[i % len(there)] for i in range(count)]


BLUE, ORANGE, GREEN, VERMILLION, SKY, YELLOW = _categories(6)
GREY, LIGHT_GREY, INK = (to_hex(_RC[name]) for name in ("axes.edgecolor", "grid.color", "text.color"))
LEFT_FACE, RIGHT_FACE = BLUE, ORANGE
STEEL, DARK_STEEL = "#C3C8D0", "#7D8592"
SEQUENTIAL: Final[str] = _RC["image.cmap"]


def style_key() -> str:
    """Hash of how pictures look: those of another style are drawn again."""
    return hashlib.sha256(repr(sorted(_RC.items(), key=lambda item: item[0])).encode()).hexdigest()


@contextmanager
def figure(path: Path, width: float, height: float) -> Iterator[Figure]:
    """A figure of so many inches, saved to `path` as PNG, and beside it as SVG and PDF, when what is inside has drawn
    it. raises: DiskError"""
    with mpl.rc_context(_RC):
        drawing = Figure(figsize=(width, height))
        yield drawing
        with written_to(path):
            write_png(Image.open(BytesIO(_png(drawing))).convert("RGB"), path)
            drawing.set_layout_engine("none")  # everything stays where the PNG has it: laid out once, not three times
            for ending in FORMATS:
                drawing.savefig(path.with_suffix(ending), metadata=_DATES[ending[1:]])


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
    drawing.savefig(buffer, dpi=_RC["savefig.dpi"], format="png")
    return buffer.getvalue()


def write_png(picture: Image.Image, path: Path) -> None:
    """With few colours: a third of the size, and it looks the same."""
    path.parent.mkdir(parents=True, exist_ok=True)
    picture.quantize(COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(path, optimize=True)


def shades(count: int) -> Sequence[Any]:
    """So many colours from dark to light, the lightest still visible on white."""
    return [colormaps[SEQUENTIAL](0.92 * i / max(count - 1, 1)) for i in range(count)]
