"""Whether what a fit leaves is what the scatter leaves."""

from updamp.comparison.fit.failing_model import Freedom
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.observations import Plan


def lack_of_fit(fit: Fit, plan: Plan, fall: float = 0.0) -> float:
    """Probability of a chi2 as large by chance, the noise known as well as it is. plan: the runs of the fit; fall: by
    which it is taken to be lower"""
    return float(Freedom(fit.freedom, plan.noise_freedom).by_chance.sf((fit.compared.chi2 - fall) / fit.freedom))
