"""What the machine's memory does not hold is refused before anything is meshed or allocated, with what would fit."""

from updamp.parallel.resources import free_memory
from updamp.rig.rig import Rig
from updamp.rig.size import USUAL, VECTORS_A_MODE, Size, size_of


def check_size(rig: Rig, preset: str, meshed: bool = False, memory: float | None = None) -> None:
    """meshed: whether the finite elements are there already; memory: that there is, by default what is free [bytes]

    raises: ValueError naming the keys, what they need, what there is, and what would fit
    """
    memory = free_memory() if memory is None else memory
    size = size_of(rig, preset)
    problems = [] if meshed else _elements(rig, preset, size, memory)
    problems += _balance(rig, preset, size, memory)
    if problems:
        raise ValueError("\n".join(problems))


def _elements(rig: Rig, preset: str, size: Size, memory: float) -> list[str]:
    problems = []
    if (needed := size.elements_memory()) > memory:
        problems.append(
            f"mesh.{preset}: its divisions make {size.unknowns:.3g} unknowns, which need about {_gb(needed)} of "
            f"memory, and {_gb(memory)} are free; at most {size.most_unknowns(memory):.3g} fit: take fewer"
        )
    modes, most = rig.reduction.modes, int(min(size.unknowns, size.damper) / VECTORS_A_MODE)
    if modes > most:
        problems.append(
            f"reduction.modes = {modes}: mesh '{preset}' has {min(size.unknowns, size.damper)} unknowns in its smaller "
            f"body, which give at most {most} modes"
        )
    return problems


def _balance(rig: Rig, preset: str, size: Size, memory: float) -> list[str]:
    if (needed := size.curve_memory()) <= memory:
        return []
    balance = rig.harmonic_balance
    matrices, samples = size.matrices_memory(), size.samples_memory()
    left = max(memory - USUAL.base - min(matrices, samples), 0.0)  # for the larger of the two
    stated = (
        f"harmonic_balance.harmonics up to {balance.harmonics[-1]}, time_samples = {balance.time_samples}, "
        f"cycles = {balance.cycles} with mesh.{preset}.contact_elements = {size.contacts}"
    )
    if matrices > samples:
        fits = int(size.balance * (left / matrices) ** 0.5)
        remedy = f"they make {size.balance:.3g} unknowns, and at most {fits} fit: take fewer contacts or harmonics"
    else:
        fits = int(size.samples * left / samples)
        remedy = f"at most {fits} samples in all cycles fit: lower time_samples, cycles or contact_elements"
    return [f"{stated}: a curve needs about {_gb(needed)} of memory, and {_gb(memory)} are free; {remedy}"]


def _gb(memory: float) -> str:
    return f"{memory / 1e9:.3g} GB"
