"""What a group of elements cannot be: said when it is made, not as an odd number or a foreign error later."""

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.hbm import contact
from updamp.hbm.contact.one_sided import OneSidedLaw
from updamp.hbm.harmonics import Harmonics, whole_number

# Sliders divide by their stiffness; laws that divide by others name them (`divides_by`): a box without normal stiffness
# had never slipped. A small one holds a load that does not vary. Other bounds are the laws' own (`at_least`, `above`).
_SLIDERS, _NOT_NEGATIVE = ("kt",), ("kn", "mu", "limit")
# Of the laws of hbm/contact. Infinity elsewhere has a meaning: a limit that is never reached, a gap never closed.
# Friction may vary over the period, mu (n_elements, n_time); how many samples there are is not known here.
_PAIRS, _MAY_VARY = ("t0",), ("mu",)
_FINITE = (
    *("coefficient", "stiffness", "kt", "kn", "n0", "t0"),
    *("dashpot", "force", "exponent", "lost", "in_phase", "out_of_phase"),
)


def refuse_impossible(law: Any, parameters: Any, rows: Any) -> None:
    """law: a `ContactLaw`; parameters, rows: as of `problem.elements.ElementGroup`

    raises: ValueError naming what is wrong; TypeError where it is no law, or an entry of a parameter is no number
    """
    if isinstance(law, type):
        raise ValueError(f"{law.__name__} is a class: give a law of it, such as {law.__name__}(...)")
    if not hasattr(law, "directions"):
        raise TypeError(f"law = {law!r}: a contact law is needed, such as CubicSpring()")
    name, shape = type(law).__name__, np.shape(rows)
    cycles = getattr(law, "cycles", 1)
    if (whole_number(cycles) or 0) < 1:
        raise ValueError(f"{name}: cycles = {cycles}; a whole number of 1 or more is needed, {name}() has enough")
    wanted = getattr(law, "parameters", tuple)
    if missing := [entry for entry in getattr(wanted, "_fields", ()) if not hasattr(parameters, entry)]:
        raise ValueError(f"{name}: its parameters are {wanted.__name__}; {', '.join(missing)} is missing")
    positive = (*_SLIDERS, *getattr(law, "divides_by", ()))
    if len(shape) != 2 or shape[1] != law.directions:
        raise ValueError(f"{name}: rows of shape {shape}; (n_elements, {law.directions}) is needed, one row an element")
    for entry, value in zip(type(parameters)._fields, parameters, strict=True):
        _refuse_entry(f"{name}: {entry}", np.asarray(value), shape[0])
        if type(law).__module__.startswith(f"{contact.__name__}."):
            varies = entry in _MAY_VARY and np.ndim(value) == 2 and np.shape(value)[1] > 1
            each = np.shape(value)[1:] if varies else (2,) if entry in _PAIRS else ()
            _refuse_value(f"{name}: {entry}", np.asarray(value), each, entry in _FINITE)
        if entry in positive and not np.all(np.asarray(value) > 0):
            raise ValueError(f"{name}: {entry} = {_told(value)} must be positive; it may be small")
        if entry in _NOT_NEGATIVE and not np.all(np.asarray(value) >= 0):
            raise ValueError(f"{name}: {entry} = {_told(value)} must not be negative")
    for entry, least in getattr(law, "at_least", {}).items():
        if not np.all(np.asarray(getattr(parameters, entry)) >= least):
            raise ValueError(f"{name}: {entry} = {_told(getattr(parameters, entry))} must be {least:g} or more")
    for entry, bound in getattr(law, "above", {}).items():
        if not np.all(np.asarray(getattr(parameters, entry)) > bound):
            raise ValueError(f"{name}: {entry} = {_told(getattr(parameters, entry))} must be above {bound:g}")


def refuse_rows(groups: Sequence[Any], n_relative: int) -> None:
    """groups: of `problem.elements.ElementGroup`

    raises: ValueError naming a row that is not there, one that two elements have, or one that none has
    """
    rows = np.concatenate([np.ravel(group.rows) for group in groups])
    there = f"the model's relative displacements are rows 0 to {n_relative - 1}, each for exactly one element"
    if len(beyond := rows[(rows < 0) | (rows >= n_relative)]):
        raise ValueError(f"rows: an element acts on row {beyond[0]}; {there}")
    times = np.bincount(rows, minlength=n_relative)
    if len(twice := np.flatnonzero(times > 1)):
        raise ValueError(f"rows: {times[twice[0]]} elements act on row {twice[0]}; {there}: give each a row of its own")
    if len(none := np.flatnonzero(times == 0)):
        raise ValueError(f"rows: no element acts on row {none[0]}; {there}: leave the row out, or give it an element")


def refuse_unmoved(groups: Sequence[Any], moves: NDArray[np.bool_]) -> None:
    """groups: of `problem.elements.ElementGroup`; moves: (n_relative,) whether any motion is seen on a row

    raises: ValueError naming an element that sees none on any of its rows
    """
    for group in groups:
        if len(still := group.rows[~moves[group.rows].any(axis=1)]):
            which = f"rows {still[0].tolist()} of it are" if len(still[0]) > 1 else f"row {still[0][0]} of it is"
            raise ValueError(
                f"relative: {which} all zeros, where a {type(group.law).__name__} acts, which would see no motion: "
                "give the coordinates' shares, or leave row and element out"
            )


def warn_of_moving_mean(groups: Sequence[Any], harmonics: Harmonics) -> None:
    """Where elements move the mean position, which is held without harmonic 0: naming the law, the row and the
    harmonics. No error, since other codes solve such problems too. groups: of `problem.elements.ElementGroup`"""
    if 0 in harmonics.orders:
        return
    for group in groups:
        if not isinstance(group.law, OneSidedLaw) or not (pushes := group.law.one_sided(group.parameters)).any():
            continue
        warnings.warn(
            f"harmonics = {harmonics.orders}: the {type(group.law).__name__} on row {group.rows[pushes][0][0]} pushes "
            f"one way alone and moves the mean position, which is held: add harmonic 0, such as {(0, 1, 2, 3)}; where "
            "it is meant to be held, NonlinearSystem(..., mean_held=True) says so",
            stacklevel=4,
        )


def whole_rows(rows: Any) -> NDArray[np.int64]:
    """Rows as integers, whole numbers written as floats too. raises: ValueError naming those that are none"""
    given = np.asarray(rows)
    if np.issubdtype(given.dtype, np.integer):
        return given
    if not np.issubdtype(given.dtype, np.floating) or not np.array_equal(given, np.round(given)):
        raise ValueError(f"rows = {_told(rows)}: whole numbers are needed, those of rows of `relative`, from 0 on")
    return given.astype(np.int64)


def as_arrays(parameters: Any) -> Any:
    """Parameters with lists made arrays. raises: TypeError where a list is none of numbers"""
    if not hasattr(parameters, "_fields") or not any(isinstance(value, list | tuple) for value in parameters):
        return parameters
    entries = zip(parameters._fields, parameters, strict=True)
    return type(parameters)(
        *(_as_array(e, value) if isinstance(value, list | tuple) else value for e, value in entries)
    )


def _as_array(entry: str, value: Any) -> NDArray[np.float64]:
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"{entry} = {value}: real numbers are needed, one for each element") from None


def _refuse_entry(what: str, value: NDArray[Any], n_elements: int) -> None:
    """Of any law, one of a user's own too, whose entries may be of any shape behind that"""
    if not (np.issubdtype(value.dtype, np.number) or value.dtype == bool or value.ndim == 0):
        raise TypeError(f"{what} = {_told(value)}: no numbers; one for each element is needed")
    if value.ndim == 0 or len(value) != n_elements:
        raise ValueError(f"{what} has shape {value.shape}; one entry for each of {n_elements} elements is needed")
    if np.isnan(value).any():
        raise ValueError(f"{what} = {_told(value)}: not a number")


def _refuse_value(what: str, value: NDArray[Any], each: tuple[int, ...], finite: bool) -> None:
    """Of a law of hbm/contact; each: shape of one element's entry; finite: whether it must be"""
    if value.shape[1:] != each:
        row = "two numbers" if each else "one number"
        raise ValueError(
            f"{what} has shape {value.shape}; {(len(value), *each)} is needed, {row} an element: reshape it to that"
        )
    if np.iscomplexobj(value):
        raise ValueError(f"{what} = {_told(value)} is complex; a real number is needed: give its real part")
    if np.isneginf(value).any() or (finite and not np.isfinite(value).all()):
        raise ValueError(f"{what} = {_told(value)} must be finite: give a large number in place of infinity")


def _told(value: Any) -> str:
    return np.array2string(np.asarray(value), precision=4, threshold=6)
