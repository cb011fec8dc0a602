"""Numbers that test engineers know from correlating models with frequency responses; secondary here, since none of
them knows how well the measurement repeats.

FRAC: P. Avitabile, "Experimental modal analysis", 2001; CSAC and CSF: H. Grafe, "Model updating of large structural
dynamics models using measured response functions", PhD thesis, Imperial College, 1998, eqs. 3.14 and 3.17.
"""

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]


def frac(measured: Complex, model: Complex) -> float:
    """Frequency response assurance criterion of one response over frequency, 0 to 1: (n,) each."""
    return float(np.abs(np.vdot(measured, model)) ** 2 / (np.vdot(measured, measured) * np.vdot(model, model)).real)


def csac(measured: Complex, model: Complex) -> float:
    """Cross signature assurance criterion of all responses at each frequency, its mean over them: (n, n_channels)."""
    cross = np.abs(np.sum(measured.conj() * model, axis=1)) ** 2
    return float(np.mean(cross / (np.sum(np.abs(measured) ** 2, axis=1) * np.sum(np.abs(model) ** 2, axis=1))))


def csf(measured: Complex, model: Complex) -> float:
    """Cross signature scale factor, the sensitivity to scale that CSAC lacks, its mean: (n, n_channels)."""
    cross = 2 * np.abs(np.sum(measured.conj() * model, axis=1))
    return float(np.mean(cross / (np.sum(np.abs(measured) ** 2, axis=1) + np.sum(np.abs(model) ** 2, axis=1))))
