"""Parameters of laws around laws: those of the inner one and the entries that the outer one adds, in one NamedTuple.

So mu, kt, kn, n0, ... are found under their names whatever has been put around the basic law.
"""

from collections import namedtuple
from functools import lru_cache
from typing import Any


def with_entries(parameters: Any, **entries: Any) -> Any:
    """The NamedTuple with these entries: those that it has are replaced, the others added behind."""
    new = {name: value for name, value in entries.items() if name not in parameters._fields}
    replaced = parameters._replace(**{name: value for name, value in entries.items() if name not in new})
    return extended_type(type(parameters), tuple(new))(*replaced, *new.values()) if new else replaced


def extended_type(base: type, entries: tuple[str, ...]) -> type:
    """A NamedTuple class with the fields of `base` and these behind."""
    fields: tuple[str, ...] = base._fields  # type: ignore[attr-defined]
    return parameter_type(base.__name__, (*fields, *(e for e in entries if e not in fields)))


@lru_cache(maxsize=256)
def parameter_type(name: str, fields: tuple[str, ...]) -> type:
    """One class for one set of fields: compiled functions are kept by it. It can be sent to other processes."""

    def reduce(self: Any) -> Any:
        return _again, (name, fields, tuple(self))

    return type(name, (namedtuple(name, fields),), {"__slots__": (), "__reduce__": reduce})


def _again(name: str, fields: tuple[str, ...], values: tuple[Any, ...]) -> Any:
    return parameter_type(name, fields)(*values)
