"""The stuck structure's answer at one frequency, harmonic by harmonic: applied, not formed."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.benchmarks.virtual_rig.assembled import Assembled
from updamp.benchmarks.virtual_rig.bench import BODIES
from updamp.benchmarks.virtual_rig.patch_forces import Basis

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class BenchReceptance:
    """modal: (H, m, m); through: (H, rows, a) receptance to the attachments; answer: (H, a, a) of these"""

    rig: Assembled
    basis: Basis
    modal: Complex
    through: Complex
    answer: Complex

    def respond(self, force: Floats, rows: NDArray[np.int64]) -> Floats:
        """(n_rows, n_c) coefficients of force on the rows with forces -> displacement of `rows`, mean excepted."""
        loaded = np.flatnonzero(force.any(axis=1))
        return self.between(loaded, rows)(force[loaded])[:, : 2 * self.basis.harmonics]

    def contacts(self, force: Floats) -> Floats:
        """(n_rows, n_c) coefficients of force on the rows with forces -> their displacement."""
        loaded = np.flatnonzero(force.any(axis=1))
        return self.between(loaded, np.arange(self.rig.n_rows))(force[loaded])

    def between(self, loaded: NDArray[np.int64], rows: NDArray[np.int64]) -> Callable[[Floats], Floats]:
        """What takes forces (k, n_c) on k loaded rows to displacements of `rows`, mean excepted beyond those with
        forces."""
        stuck, H = self.rig.stuck, self.basis.harmonics
        to_modes, from_modes = np.ascontiguousarray(stuck.phi[loaded].T), stuck.phi[rows]
        residual = stuck.residual[np.ix_(rows, loaded)]
        pulling, pulled = self.through[:, loaded].transpose(0, 2, 1), self.through[:, rows]
        n = self.rig.n_rows
        mean = self.rig.mean_compliance[np.ix_(rows, loaded)] if self.basis.mean and (rows < n).all() else None

        def displacement(force: Floats) -> Floats:
            f = np.ascontiguousarray(force[:, : 2 * H])
            q = (to_modes @ f).view(complex)
            y = from_modes @ np.ascontiguousarray(_each(self.modal, q)).view(float) + residual @ f
            attached = _each(self.answer, _each(pulling, f.view(complex)))
            y -= np.ascontiguousarray(_each(pulled, attached)).view(float)
            return np.asarray(y if mean is None else np.column_stack([y, mean @ force[:, -1]]))

        return displacement

    def excited(self, row: int) -> Complex:
        """(rows,) displacement under a unit force cos(w t) on a row."""
        stuck = self.rig.stuck
        y = stuck.phi @ (self.modal[0] @ stuck.phi[row]) + stuck.residual[:, row]
        return np.asarray(y - self.through[0] @ (self.answer[0] @ self.through[0, row]))


def _each(matrices: Complex, columns: Complex) -> Complex:
    """(H, i, j) times (j, H), column by column -> (i, H)"""
    return np.asarray((matrices @ columns.T[:, :, None])[:, :, 0].T)


def receptance(rig: Assembled, basis: Basis, w: float, tip_amplitude: dict[str, float]) -> BenchReceptance:
    """tip_amplitude: of the blades, which the loss factor may grow with [m]"""
    bench, stuck = rig.bench, rig.stuck
    loss = {b: own * (1 + bench.loss_growth * tip_amplitude.get(b, 0.0)) for b, own in bench.loss_factors.items()}
    damping = sum(loss[b] * rig.free.elastic[b] for b in BODIES)
    V, modal, through, answer = rig.attached.T, [], [], []
    for k in range(1, basis.harmonics + 1):
        part = 1.0 if bench.viscous_at is None else k * w / bench.viscous_at
        inverse = np.linalg.inv(stuck.stiffness - (k * w) ** 2 * stuck.mass + 1j * part * damping)
        G = stuck.phi @ (inverse @ (stuck.phi.T @ V)) + stuck.residual @ V
        z = np.array([a.dynamic_stiffness(k * w) for a in bench.attachments])
        modal.append(inverse)
        through.append(G)
        answer.append(np.linalg.solve(np.eye(len(z)) + z[:, None] * (V.T @ G), np.diag(z)))
    return BenchReceptance(rig, basis, np.array(modal), np.array(through), np.array(answer))
