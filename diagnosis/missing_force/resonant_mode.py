"""The mode that resonates in a test."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.prediction.held_branch import force_at
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.newton.structure_response import all_loads, respond
from updamp.hbm.problem.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


# Neighbours whose frequency is within this factor of the resonant one's are separated from it by the sensors.
_NEAR = 2.0
# Least singular value over the largest of what the sensors see of modes of equal size, for them to be separated.
_APART = 0.1


@dataclass(frozen=True)
class ResonantMode:
    """A mode of the structure with all contacts stuck, as seen at a channel.

    point: the channel's; numbers: of the mode, then of its neighbours that the sensors tell from it; shape: of the mode
    at the channel [kg^-1/2]; omega: its [rad/s]
    """

    point: str
    numbers: tuple[int, ...]
    shape: float
    omega: float


def resonant_mode(branch: PredictedBranch, excitation: str) -> ResonantMode:
    """The mode that moves the channel most where the branch peaks, at the channel of largest first harmonic.

    excitation: name of the point that the shaker acts on
    raises: ValueError where no sensor has the first harmonic
    """
    first = first_harmonics(branch)
    height = np.abs(branch.amplitude[:, first])
    at, sensor = (int(i) for i in np.unravel_index(np.argmax(height), height.shape))
    point = branch.points[at]
    system = system_at(point)
    rows = [system.free.row(branch.condition.sensors[i][0]) for i in first]
    shapes = system.stuck.phi[rows]
    q = modal_amplitudes(point, Excitation(system.free.row(excitation), force_at(point, branch.condition)))
    number = int(np.argmax(np.abs(shapes[sensor] * q)))
    omega = np.sqrt(np.maximum(system.stuck.omega_squared, 0.0))
    channel = branch.condition.sensors[first[sensor]][0]
    return ResonantMode(
        channel, _distinguishable(shapes, omega, number), float(shapes[sensor, number]), float(omega[number])
    )


def _distinguishable(shapes: Floats, omega: Floats, number: int) -> tuple[int, ...]:
    """The mode with its neighbours, nearest first. shapes: (n_sensors, m); omega: (m,)"""
    numbers = [number]
    distance = np.abs(np.log(np.maximum(omega, np.finfo(float).tiny) / omega[number]))
    for i in np.argsort(distance)[1:]:
        columns = shapes[:, [*numbers, i]]
        size = np.linalg.norm(columns, axis=0)
        if distance[i] > np.log(_NEAR) or len(numbers) == len(shapes):
            break
        if size.all() and np.linalg.svd(columns / size, compute_uv=False)[-1] > _APART:
            numbers.append(int(i))
    return tuple(numbers)


def first_harmonics(branch: PredictedBranch) -> list[int]:
    """Places of the sensors that have it.

    raises: ValueError where none has
    """
    first = [i for i, (_, k) in enumerate(branch.condition.sensors) if k == 1]
    if not first:
        raise ValueError(
            f"test {branch.condition.name!r}: no sensor has the first harmonic, which the missing force is read off; "
            "compare harmonic 1 too"
        )
    return first


def modal_amplitudes(point: BranchPoint, excitation: Excitation) -> Complex:
    """(m,) first harmonic of every stuck mode's coordinate [m kg^1/2]"""
    equation = point.solution.equation
    coordinates = respond(equation.receptance, all_loads(equation, excitation)).modal[..., 0]
    return system_at(point).harmonics.amplitude(coordinates, 1)


def system_at(point: BranchPoint) -> NonlinearSystem:
    return point.solution.equation.receptance.system
