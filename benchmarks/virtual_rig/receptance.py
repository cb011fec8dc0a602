"""The stuck structure's answer at one frequency, harmonic by harmonic: applied, not formed."""

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

    def respond(self, force: Floats, rows: slice | NDArray[np.int64]) -> Floats:
        """(n_rows, n_c) coefficients of force on the rows with forces -> displacement of `rows`, mean excepted."""
        stuck, n, H = self.rig.stuck, self.rig.n_rows, self.basis.harmonics
        f = np.ascontiguousarray(force[:, : 2 * H])
        q = np.ascontiguousarray(stuck.phi[:n].T @ f).view(complex)
        y = stuck.phi[rows] @ np.ascontiguousarray(_each(self.modal, q)).view(float) + stuck.residual[rows, :n] @ f
        pulled = _each(self.answer, _each(self.through[:, :n].transpose(0, 2, 1), f.view(complex)))
        return np.asarray(y - np.ascontiguousarray(_each(self.through[:, rows], pulled)).view(float))

    def contacts(self, force: Floats) -> Floats:
        """As `respond`, on the rows with forces and with the mean."""
        n = self.rig.n_rows
        y = self.respond(force, slice(n))
        if self.basis.mean:
            y = np.column_stack([y, self.rig.mean_compliance @ force[:, -1]])
        return y

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
