"""How functions are compiled by numba, and where what is compiled is kept.

Not in numba's own place beside the source, which may be read-only. The folder is named by a hash of the sources here:
numba itself would only see a change in the file of the function that is kept, not in those of the functions it calls.
Nothing is reordered (no fastmath), so that results differ as little between machines as those of compiled C do.
"""

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba import config as numba_config

from updamp.hbm.compilation_cache import cache_folder

config: Any = numba_config  # its entries are made when it is loaded, and unknown to mypy


def inner(function: Callable[..., Any]) -> Any:
    """For functions that other compiled functions call."""
    return numba.njit(error_model="numpy")(function)


def kept(function: Callable[..., Any]) -> Any:
    """For functions that Python calls: kept between runs where there is a place that can be written to."""
    folder = _folder()
    if folder is None:
        return inner(function)
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder)
    try:
        return numba.njit(error_model="numpy", cache=True)(function)
    finally:
        config.CACHE_DIR = before


def _folder() -> Path | None:
    sources = b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py")))
    folder = cache_folder() / f"kernels-{hashlib.sha256(sources).hexdigest()[:12]}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None
