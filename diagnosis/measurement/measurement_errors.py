"""What is said of data that cannot be used."""

from collections.abc import Iterable
from difflib import get_close_matches


class MeasurementError(ValueError):
    """Data that cannot be used as they are; the message names the file, the value and the remedy."""


def near(name: str, known: Iterable[str], shown: int = 12) -> str:
    """ "did you mean a or b?" where something known comes close, else what there is."""
    names = list(known)
    if close := get_close_matches(name, names, n=3, cutoff=0.6):
        return f"did you mean {' or '.join(close)}?"
    more = f" and {len(names) - shown} more" if len(names) > shown else ""
    return f"there are {', '.join(names[:shown])}{more}" if names else "there are none"
