"""Modes of a test at forces so small that no contact slips or opens further, each at its own frequency, and how far
that goes (`hbm/problem/small_amplitude.py`).
"""

from collections.abc import Callable, Mapping

import numpy as np

from updamp.effects.rig_model import RigModel
from updamp.fem.coupled_modes import first_mode
from updamp.hbm.problem.linear_model import LinearModel
from updamp.hbm.problem.small_amplitude import SmallAmplitude, element_stiffness, modes_on
from updamp.hbm.problem.structural_changes import attach

_ROUNDS = 2  # of the frequency that dashpots act at


def small_amplitude(model: RigModel, near: float) -> SmallAmplitude:
    """near: frequency [Hz] that dashpots and films are taken at"""
    free = model.system.free
    return modes_on(free, element_stiffness(model.groups, free.n_relative, near), 2 * np.pi * near)


def settled(
    model: RigModel, choose: Mapping[str, float], place: Callable[[SmallAmplitude], Mapping[str, int]]
) -> dict[str, tuple[SmallAmplitude, int]]:
    """Each mode at its own frequency: name -> solution and number of the mode in it.

    choose: name -> frequency to begin with [Hz]; place: numbers of the modes in a solution. Springs keep their
    stiffness and dashpots grow with frequency: the elements are asked once.
    """
    free, first = model.system.free, min(choose.values())
    K = element_stiffness(model.groups, free.n_relative, first)
    found = modes_on(free, K, 2 * np.pi * first)
    if not (np.any(K.imag) or np.any(free.viscous)):
        return {name: (found, i) for name, i in place(found).items() if name in choose}
    each = {}
    for name in choose:
        at = found
        for _ in range(_ROUNDS):
            f = float(at.frequencies[place(at)[name]])
            at = modes_on(free, K.real + 1j * K.imag * f / first, 2 * np.pi * f)
        each[name] = at, place(at)[name]
    return each


def modes_by_name(model: RigModel, near: float) -> dict[str, float]:
    """ "OOP" and "IP", the first modes whose tips move against each other and together -> frequency [Hz]

    near: as for `small_amplitude`; raises: ValueError where there is no such mode
    """
    found = small_amplitude(model, near)
    return {name: float(found.frequencies[number]) for name, number in numbers_by_name(found).items()}


def numbers_by_name(found: SmallAmplitude) -> dict[str, int]:
    """Likewise, name -> number of the mode; none of a structure that is not two blades."""
    points = [f"blade_{side}.tip.x" for side in ("left", "right")]
    if not set(points) <= set(found.free.points):
        return {}
    tips = np.real([found.shapes[found.free.row(point)] for point in points]).T
    return {"OOP": first_mode(tips, in_phase=False), "IP": first_mode(tips, in_phase=True)}


def without_contacts(model: RigModel, component: str, number: int = 0) -> float:
    """Frequency [Hz] of one component alone, with what is attached to it and to nothing else.

    number: of its modes, 0 for the first; raises: IndexError for one beyond those kept
    """
    own = [a for a in model.attachments if all(p.startswith(f"{component}.") for p in a.points)]
    on = np.array(model.owner) == component
    c = model.components
    alone = LinearModel(
        c.omega_squared[on], c.phi[:, on], c.residual, c.hysteretic[np.ix_(on, on)], c.viscous[np.ix_(on, on)],
        c.n_relative, c.points,
    )  # fmt: skip
    return float(attach(alone, own).frequencies[number])


def linear_up_to(model: RigModel, found: SmallAmplitude, mode: int) -> float:
    """Force [N] at which the first closed contact slips or opens at the mode's resonance, by the linear response.

    Read off the inner friction law: tangential springs against mu N0 in each direction, the normal spring against N0.
    raises: ValueError where the model has no contacts
    """
    if model.contacts is None:
        raise ValueError("this model has no contacts that could slip")
    p, rows = model.contacts.parameters, np.asarray(model.contacts.rows)
    K = element_stiffness((model.contacts,), found.free.n_relative, float(found.frequencies[mode]))
    shape, drive = found.shapes[:, mode], abs(found.at(model.excitation, mode)) / float(found.squared[mode].imag)
    force = np.abs(K @ shape[: found.free.n_relative]) * drive  # per N
    closed = np.asarray(p.n0) - np.asarray(p.kn) * np.asarray(p.gap) > 0
    limit = np.stack([np.asarray(p.mu) * p.n0, np.asarray(p.mu) * p.n0, np.asarray(p.n0)], axis=1)[closed]
    return float(np.min(limit / np.maximum(force[rows[closed]], np.finfo(float).tiny)))
