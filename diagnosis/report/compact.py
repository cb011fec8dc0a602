"""Numbers for the page: as many digits as a plot can show, so that a report stays small."""

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

DIGITS = 7  # 430.0001 Hz and 430.0002 Hz stay apart; curves of 0.01 % bandwidth need that


def script_json(value: Any) -> str:
    """JSON that may stand inside a script element. Arrays and floats to 7 digits, nan and infinities as null."""
    text = json.dumps(_plain(value), allow_nan=False, separators=(",", ":"), ensure_ascii=False)
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(entry) for entry in value]
    if isinstance(value, float):
        return _short(value)
    return value


def _short(value: float) -> float | int | None:
    if not math.isfinite(value):
        return None
    short = float(f"{value:.{DIGITS}g}")
    return int(short) if short.is_integer() and abs(short) < 1e7 else short
