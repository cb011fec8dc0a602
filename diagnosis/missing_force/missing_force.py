"""The force that the model lacks in each mode, as stiffness and damping against amplitude.

The measured motion put into the model's equation of the resonant mode m leaves a force over,

    r = f_ext - Z q - f_nl(q) = (k + i w c) a     at the channel,

a the displacement there: k = Re(r/a) [N/m] and c = Im(r/(w a)) [N s/m] are what would have to be added to the
model. modal_expansion.py finds q, with everything that slips along with it, for each measured point, and how k and c
change with what was observed, M = d(k, c) / d(log frequency, log amplitudes, phases).

The model that a point is put into is that of its assembly: branches are solved at common parameters, so the point is
moved instead, by the offsets of its assembly (Offsets, through the branch's slopes at the point's place on it). To
first order in what is still unknown, observations y off by the sensors' noise e and offsets b (U their slopes),

    (k, c) = (k, c)(A) + M (e + U b + S du),

S the branch's slopes by the calibration. All points of a mode are one least squares problem with covariance
M (noise + U U^T) M^T, so that repeats do not count as independent where an assembly's offset moves a run as a whole.
Unknowns pieced by amplitude are averages over repeats, with their standard deviations: the picture. Calibration is held
for these values; what it may have taken up is left to the reading (force_laws.py).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.compared import Compared
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.offsets import assembly
from updamp.comparison.fit.scatter import whitened
from updamp.comparison.prediction.model_at import ModelAt
from updamp.comparison.prediction.observed_point import with_matrices
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.diagnosis.missing_force.expanded_run import ExpandedRun, expanded_run
from updamp.diagnosis.missing_force.force_laws import DAMPING, LEVELS, POWERS, STIFFNESS, Column, Squares, force_laws
from updamp.diagnosis.missing_force.force_reading import ReferenceMotion, reading
from updamp.diagnosis.missing_force.resonant_mode import ResonantMode, resonant_mode
from updamp.diagnosis.verdict import MissingForce

Floats = NDArray[np.float64]
Unknowns = Callable[[ExpandedRun], Floats]

# About how many pieces of amplitude a level has, measured points that each has at least, and how many times its
# smallest amplitude the largest may be where there are enough points.
_PIECES, _POINTS, _WIDEST = 6, 6, 1.5


def missing_forces(compared: Compared, parametrisation: Parametrisation, plan: Plan) -> tuple[MissingForce, ...]:
    """One for each mode of the plan: values by level and amplitude, and what their shape says.

    compared: of the plan, with branches solved near compared.u
    raises: ValueError where a mode has no sensor with the first harmonic
    """
    compared = replace(compared, as_many=0.0)  # what the model lacks is what is read here, and counts as no noise
    compared = replace(compared, branches=tuple(_with_matrices(b, parametrisation) for b in compared.branches))
    modes = _resonant_modes(compared, parametrisation, plan)
    runs = _expanded(compared, parametrisation, plan, modes)
    modes = {mode: resonant for mode, resonant in modes.items() if _of(mode, plan, runs)}
    references = {mode: _reference(resonant, _of(mode, plan, runs)) for mode, resonant in modes.items()}
    pieces = _pieces(plan, runs)
    laws = [Column(m, q, p) for m in modes for q, powers in POWERS.items() for p in powers]
    names = laws + [Column(piece.mode, LEVELS) for piece in pieces for _ in (STIFFNESS, DAMPING)]

    def unknowns(run: ExpandedRun) -> Floats:
        of_laws = [_law_column(run, plan, column, references) for column in laws]
        of_pieces = [_piece_column(run, piece, i) for piece in pieces for i in (0, 1)]
        return np.stack([*of_laws, *of_pieces], axis=2)

    residual, calibration, extra = _equations(compared, parametrisation, plan, runs, unknowns)
    squares = Squares(residual, calibration, parametrisation.deviation, compared.u, extra, names)
    found = force_laws(squares, tuple(modes))
    values = _in_pieces(residual, extra[:, len(laws) :], squares.noise)
    return tuple(_missing_force(mode, pieces, values, reading(found[mode], references[mode])) for mode in modes)


def _with_matrices(branch: PredictedBranch, parametrisation: Parametrisation) -> PredictedBranch:
    there = ModelAt(parametrisation, branch.u).at(branch.condition)
    points = with_matrices(there, branch.condition, branch.points)
    return replace(branch, points=points)


def _expanded(
    compared: Compared, parametrisation: Parametrisation, plan: Plan, modes: dict[str, ResonantMode]
) -> tuple[ExpandedRun, ...]:
    excitation = parametrisation.base.excitation
    runs = []
    for matched in compared.matched:
        test = matched.observations.test
        run = expanded_run(matched, compared.branches[test], excitation, modes[plan.conditions[test].mode])
        if run is not None:
            runs.append(run)
    return tuple(runs)


def _of(mode: str, plan: Plan, runs: Sequence[ExpandedRun]) -> list[ExpandedRun]:
    return [run for run in runs if plan.conditions[run.test].mode == mode]


def _reference(resonant: ResonantMode, runs: Sequence[ExpandedRun]) -> ReferenceMotion:
    """With the frequency at which most is seen of the mode."""
    amplitude, w = (np.concatenate([getattr(run, name) for run in runs]) for name in ("amplitude", "w"))
    return ReferenceMotion(resonant.point, float(amplitude.max()), float(np.average(w, weights=amplitude**2)))


def _resonant_modes(compared: Compared, parametrisation: Parametrisation, plan: Plan) -> dict[str, ResonantMode]:
    """Told from the lowest level of each mode, where contacts slip least."""
    modes = {}
    for mode in dict.fromkeys(c.mode for c in plan.conditions):
        tests = [i for i, c in enumerate(plan.conditions) if c.mode == mode]
        lowest = min(tests, key=lambda i: plan.conditions[i].force)
        modes[mode] = resonant_mode(compared.branches[lowest], parametrisation.base.excitation)
    return modes


@dataclass(frozen=True, eq=False)
class _Piece:
    """Amplitudes of one level from `low` up to `high` [m]; centre: their mean, weighted with what each point tells of
    the stiffness"""

    mode: str
    level: float
    tests: tuple[int, ...]
    low: float
    high: float
    centre: float

    def has(self, run: ExpandedRun) -> NDArray[np.bool_]:
        """(n,)"""
        return (run.test in self.tests) & (run.amplitude >= self.low) & (run.amplitude < self.high)


def _pieces(plan: Plan, runs: Sequence[ExpandedRun]) -> tuple[_Piece, ...]:
    """Of all repeats and sweeps of each level."""
    found = []
    for mode, level in dict.fromkeys((c.mode, c.level) for c in plan.conditions):
        tests = tuple(i for i, c in enumerate(plan.conditions) if (c.mode, c.level) == (mode, level))
        own = [run for run in runs if run.test in tests]
        if not own:
            continue
        amplitude = np.concatenate([run.amplitude for run in own])
        weight = np.concatenate([np.sum(run.by_force[:, :, 0] ** 2, axis=1) for run in own])
        order = np.argsort(amplitude)
        groups = _groups(amplitude[order])
        edges = [*(float(amplitude[order[group[0]]]) for group in groups), np.inf]
        for low, high, group in zip(edges[:-1], edges[1:], groups, strict=True):
            centre = float(np.average(amplitude[order[group]], weights=weight[order[group]]))
            found.append(_Piece(mode, level, tests, low, high, centre))
    return tuple(found)


def _groups(amplitude: Floats) -> list[list[int]]:
    """Neighbours in ascending amplitudes, as many as make a piece."""
    most = max(_POINTS, len(amplitude) // _PIECES)
    groups: list[list[int]] = [[0]]
    for i in range(1, len(amplitude)):
        group = groups[-1]
        wide = amplitude[i] > _WIDEST * amplitude[group[0]] and len(group) >= _POINTS
        if (wide or len(group) >= most) and len(amplitude) - i >= _POINTS:
            groups.append([])
        groups[-1].append(i)
    return groups


def _law_column(run: ExpandedRun, plan: Plan, column: Column, references: dict[str, ReferenceMotion]) -> Floats:
    """(n, 2)"""
    of_quantity = run.by_force[:, :, (STIFFNESS, DAMPING).index(column.quantity)]
    if plan.conditions[run.test].mode != column.mode:
        return np.zeros_like(of_quantity)
    return of_quantity * (run.amplitude[:, None] / references[column.mode].amplitude) ** column.power


def _piece_column(run: ExpandedRun, piece: _Piece, quantity: int) -> Floats:
    """(n, 2)"""
    return run.by_force[:, :, quantity] * piece.has(run)[:, None]


def _equations(
    compared: Compared, parametrisation: Parametrisation, plan: Plan, runs: Sequence[ExpandedRun], unknowns: Unknowns
) -> tuple[Floats, Floats, Floats]:
    """Whitened: residual (n,), by the calibration's parameters (n, p), by the unknowns (n, c)."""
    names = tuple(n.name for n in parametrisation.nuisances)
    p, parts = len(parametrisation), []
    for repeat in plan.repeats:
        of_repeat = [run for run in runs if run.matched.observations.repeat == repeat]
        conditions = [plan.conditions[run.test] for run in of_repeat]
        wider = [
            replace(run.matched, by_parameter=np.concatenate([run.matched.by_parameter, unknowns(run)], axis=2))
            for run in of_repeat
        ]
        parts.append(whitened(assembly(repeat, wider, conditions, names, compared.offsets[repeat]), compared.scatter))
    residual, columns = (np.concatenate(each) for each in zip(*parts, strict=True))
    return residual, columns[:, :p], columns[:, p:]


def _in_pieces(residual: Floats, columns: Floats, noise: float) -> tuple[Floats, Floats]:
    """Values of all pieces and their standard deviations: (n_pieces, 2) each."""
    scale = np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
    inverse = np.linalg.pinv((columns / scale).T @ (columns / scale), rcond=1e-12, hermitian=True)
    value = inverse @ ((columns / scale).T @ residual) / scale
    deviation = np.sqrt(noise * np.diag(inverse)) / scale
    return value.reshape(-1, 2), deviation.reshape(-1, 2)


def _missing_force(mode: str, pieces: Sequence[_Piece], values: tuple[Floats, Floats], text: str) -> MissingForce:
    own = [i for i, piece in enumerate(pieces) if piece.mode == mode]
    value, deviation = values[0][own], values[1][own]
    return MissingForce(
        mode,
        np.array([pieces[i].level for i in own]),
        np.array([pieces[i].centre for i in own]),
        value[:, 0],
        deviation[:, 0],
        value[:, 1],
        deviation[:, 1],
        text,
    )
