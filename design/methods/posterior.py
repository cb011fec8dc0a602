"""The family of rigs that meet targets within their tolerances: a posterior over the variables, not one best design.

Designs of a Latin hypercube, and then some drawn from the posterior so far, are solved. Each response gets a quadratic
emulator in the variables (a response surface: Myers, Montgomery and Anderson-Cook 2016), fitted by least squares in
which a design counts less the further it is from the targets. Its squares and products are held small by as much as
makes the leave-one-out residuals smallest (ridge regression: Hoerl and Kennard 1970), so that few designs do. The
posterior has a uniform prior over the bounds and a normal likelihood, whose variance is that of the tolerance and of
the emulator's own error (its leave-one-out residuals). It is sampled by importance sampling from the prior: no chain
that could get stuck.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from scipy.stats import qmc

from updamp.design.goals import Objective, Target
from updamp.design.methods.least_squares import only_targets
from updamp.design.methods.method import Evaluate, Method, MethodResult, Problem, method
from updamp.design.methods.sobol import Seed
from updamp.design.records import Record
from updamp.design.variables import Variable

Floats = NDArray[np.float64]

_BATCH = 50_000  # draws from the prior at once
_KEPT = 4_000  # equally probable draws that are handed on
_HELD = np.logspace(-8, 2, 21)  # how much squares and products are held small
_LARGEST = 0.25  # share of a direction's largest entry below which an entry is not named


@method("posterior")
class Posterior(Method):
    """samples: of the Latin hypercube; rounds, designs_a_round: how often designs are drawn from the posterior so far
    and solved, and how many; draws: of the prior at most; effective: draws that are enough, by their effective number
    (Kish)
    """

    samples: Annotated[int, Field(strict=True, ge=8)] = 48
    rounds: Annotated[int, Field(strict=True, ge=0)] = 2
    designs_a_round: Annotated[int, Field(strict=True, ge=2)] = 12
    draws: Annotated[int, Field(strict=True, ge=1000)] = 4_000_000
    effective: Annotated[int, Field(strict=True, ge=100)] = 4_000
    seed: Seed = 1

    def problem(self, variables: Sequence[Variable], objectives: Sequence[Objective]) -> str:
        return only_targets(variables, objectives)

    def run(self, problem: Problem, evaluate: Evaluate) -> MethodResult:
        """raises: ValueError where hardly more designs are known than there are variables"""
        rng = np.random.default_rng(self.seed)
        shares = qmc.LatinHypercube(len(problem.variables), rng=rng).random(self.samples)
        total = self.samples + self.rounds * self.designs_a_round
        records = evaluate([problem.values(one) for one in shares], total)
        for _ in range(self.rounds):
            family = self._family(problem, shares, records, rng)
            further = family.designs(self.designs_a_round, rng)
            shares = np.vstack([shares, further])
            records += evaluate([problem.values(one) for one in further], total)
        family = self._family(problem, shares, records, rng)
        found = _result(problem, family, records)
        return replace(found, notes=(*found.notes, *self._few_draws(family)))

    def _few_draws(self, family: "Family") -> list[str]:
        if family.effective >= self.effective:
            return []
        return [
            f"the posterior rests on {family.effective:.3g} independent draws of {self.draws} from the bounds, where "
            f"{self.effective} are asked for: narrow the bounds, or raise `draws`"
        ]

    def _family(
        self, problem: Problem, shares: Floats, records: Sequence[Record], rng: np.random.Generator
    ) -> "Family":
        known = [i for i, record in enumerate(records) if problem.losses(record) is not None]
        residuals = np.array([_residuals(problem, records[i]) for i in known])
        emulator = Emulator.fitted(shares[known], residuals)
        return _sampled(emulator, len(problem.variables), self.draws, self.effective, rng)


@dataclass(frozen=True, eq=False)
class Emulator:
    """Residuals of the targets, (response - target) / tolerance, as quadratic functions of the shares.

    coefficients: (n_terms, n_targets); error: (n_targets,) of a prediction, root mean square [tolerances]
    """

    coefficients: Floats
    error: Floats

    @staticmethod
    def fitted(shares: Floats, residuals: Floats) -> "Emulator":
        """shares: (n, n_variables); residuals: (n, n_targets). raises: ValueError for too few designs"""
        n, n_variables = shares.shape
        if n < n_variables + 3:
            raise ValueError(f"{n} designs are known, at least {n_variables + 3} are needed: raise `samples`")
        terms = quadratic_terms(shares)
        second_order = (np.arange(terms.shape[1]) > n_variables).astype(float)
        weight = 1 / (1 + np.square(residuals).mean(axis=1))
        fits = [_ridge(terms, residuals, weight, held * second_order) for held in _HELD]
        coefficients, errors = (np.stack(part) for part in zip(*fits, strict=True))
        best, targets = errors.argmin(axis=0), np.arange(residuals.shape[1])
        return Emulator(coefficients[best, :, targets].T, errors[best, targets])

    def log_likelihood(self, shares: Floats) -> Floats:
        """(n,)"""
        residuals = quadratic_terms(shares) @ self.coefficients
        return np.asarray(-0.5 * (np.square(residuals) / (1 + self.error**2)).sum(axis=1))


def _ridge(terms: Floats, residuals: Floats, weight: Floats, penalty: Floats) -> tuple[Floats, Floats]:
    """Coefficients (n_terms, n_targets), and the root mean square of the leave-one-out residuals (n_targets,)."""
    normal = terms.T @ (weight[:, None] * terms) + np.diag(penalty)
    solved = np.linalg.solve(normal, (weight[:, None] * terms).T)
    coefficients = solved @ residuals
    leverage = np.einsum("it,ti->i", terms, solved)
    left_out = (residuals - terms @ coefficients) / (1 - leverage)[:, None]
    return coefficients, np.sqrt(weight @ np.square(left_out) / weight.sum())


def quadratic_terms(shares: Floats) -> Floats:
    """1, all variables, their squares and products, variables from -1 to 1: (n, n_variables) -> (n, n_terms)"""
    x = 2 * shares - 1
    first, second = np.triu_indices(x.shape[1])
    return np.hstack([np.ones((len(x), 1)), x, x[:, first] * x[:, second]])


@dataclass(frozen=True, eq=False)
class Family:
    """draws: (n, n_variables) equally probable, as shares of the ranges; effective: number of independent ones that
    they are worth; volume: share of the prior that the posterior takes, likewise; emulator: what it is from"""

    draws: Floats
    effective: float
    volume: float
    emulator: Emulator

    def designs(self, most: int, rng: np.random.Generator) -> Floats:
        """(n, n_variables) of the draws, no two alike: a narrow posterior has drawn few again and again"""
        different, often = np.unique(self.draws, axis=0, return_counts=True)
        chosen = rng.choice(len(different), min(most, len(different)), replace=False, p=often / often.sum())
        return different[chosen]


def _sampled(emulator: Emulator, n: int, most: int, wanted: float, rng: np.random.Generator) -> Family:
    shares, logs = np.zeros((0, n)), np.zeros(0)
    tried, effective = 0, 0.0
    while tried < most and effective < wanted:
        fresh = rng.random((_BATCH, n))
        shares, logs = np.vstack([shares, fresh]), np.concatenate([logs, emulator.log_likelihood(fresh)])
        tried += _BATCH
        likely = logs > logs.max() - 20  # what is left out weighs less than 1e-8
        shares, logs = shares[likely], logs[likely]
        weight = np.exp(logs - logs.max())
        effective = float(weight.sum() ** 2 / np.square(weight).sum())
    chosen = rng.choice(len(weight), _KEPT, p=weight / weight.sum())
    return Family(shares[chosen], effective, effective / tried, emulator)


def _residuals(problem: Problem, record: Record) -> list[float]:
    residuals = []
    for one in problem.objectives:
        value = record.responses[one.response]
        assert isinstance(one.goal, Target), "all objectives are targets"
        assert value is not None, "its loss is known"
        residuals.append(one.goal.residual(value))
    return residuals


def _result(problem: Problem, family: Family, records: Sequence[Record]) -> MethodResult:
    """A variable's range is from the 5th to the 95th percentile; of the prior that is 90 % of the bounds' distance."""
    low, middle, high = np.quantile(family.draws, [0.05, 0.5, 0.95], axis=0)
    variables = {
        one.name: {
            "unit": one.unit,
            "prior": [one.lower, one.upper],
            "posterior": [one.at(low[i]), one.at(high[i])],
            "median": one.at(middle[i]),
            "narrowed_to": float((high[i] - low[i]) / 0.9),
        }
        for i, one in enumerate(problem.variables)
    }
    names = [one.name for one in problem.variables]
    targets = [one.response for one in problem.objectives]
    summary = {
        "variables": variables,
        "combinations": combinations(family.draws, names),
        "emulator_error_in_tolerances": dict(zip(targets, family.emulator.error.tolist(), strict=True)),
        "effective_draws": family.effective,
        "share_of_prior": family.volume,
        "designs_not_known": sum(problem.losses(record) is None for record in records),
    }
    notes = [f"{name}: {_range(one)}" for name, one in variables.items()]
    columns = zip(problem.variables, family.draws.T, strict=True)
    draws = {one.name: np.array([one.at(share) for share in column]) for one, column in columns}
    return MethodResult(summary=summary, notes=tuple(notes), draws=draws)


def _range(one: dict[str, Any]) -> str:
    (a, b), (c, d) = one["prior"], one["posterior"]
    return f"{c:.4g} to {d:.4g} of {a:.4g} to {b:.4g} {one['unit']}".rstrip()


def combinations(draws: Floats, names: Sequence[str]) -> list[dict[str, Any]]:
    """The directions in which the posterior is narrowest to widest: principal axes of its covariance, the variables as
    shares of their ranges. deviation: over that of the prior, 1 is not determined at all; weights: entries of the
    axis, those that are large"""
    values, axes = np.linalg.eigh(np.cov(draws.T))
    found = []
    for value, axis in zip(values, axes.T, strict=True):
        axis = axis * np.sign(axis[np.abs(axis).argmax()])
        large = np.abs(axis) > _LARGEST * np.abs(axis).max()
        weights = {name: round(float(w), 3) for name, w, named in zip(names, axis, large, strict=True) if named}
        found.append({"deviation": float(np.sqrt(12 * value)), "weights": weights})
    return found
