"""What the search has found out, as plain numbers: all that the decision is made from."""

from collections.abc import Mapping
from dataclasses import dataclass

from updamp.comparison.fit.failing_model import Freedom
from updamp.comparison.json_document import JsonDocument


@dataclass(frozen=True)
class IfRepeatable:
    """A fit, had another repeatability been stated (relative). excess, held_out, unseen: as for a `Trial`; misfit: what
    drops are differences of (`comparison/fit/compared.py: misfit`)"""

    repeatability: float
    excess: float
    misfit: float
    held_out: float
    unseen: float


@dataclass(frozen=True)
class IfRunsDrift:
    """The model without effects, had every run a resonance of its own. drift: relative standard deviation of these;
    excess, unseen: as for a `Trial`"""

    drift: float
    excess: float
    unseen: float


@dataclass(frozen=True)
class Trial:
    """A fit with effects in the model.

    effects: names; excess: mean squared misfit on the runs of the fit
    drop: of chi-square and priors, from the model without the effects
    delta_bic: from the best model with one effect less
    held_out: weighted residual RMS on runs that the fit never saw, nan where there are none or it is not full
    unseen: mean squared misfit on these, in units of what the prediction is uncertain by too, nan likewise
    at_bound: parameter at the bound of what is physical, "" if none; full: whether the fit was left to settle
    farthest: what stands farthest from where it was stated to be (`baseline.farthest_off`); deviations: how many of its
        prior ones
    parameters: of its effects; if_repeatable: had other repeatabilities been stated, none where repeats tell
    may_be_absent: effect whose intervals hold its null values, "" if none or the fit is not full
    """

    effects: tuple[str, ...]
    excess: float
    drop: float
    delta_bic: float
    held_out: float
    at_bound: str
    full: bool
    farthest: str = ""
    deviations: float = 0.0
    parameters: int = 1
    if_repeatable: tuple[IfRepeatable, ...] = ()
    unseen: float = float("nan")
    may_be_absent: str = ""


@dataclass(frozen=True)
class EffectScore:
    """Score test of one effect. score: in standard deviations; alone: that of the residual and the signature alone,
    neither orthogonal to the nuisance parameters; without_scatter: as if repeats did not differ"""

    effect: str
    score: float
    visibility: float
    drop: float
    alone: float
    without_scatter: float


@dataclass(frozen=True)
class Evidence:
    """excess, held_out, unseen: as for a `Trial`, of the model without effects
    repeatability: RMS of what differs between repeats
    tested: the highest score first; trials: of single effects; combined: of two and more
    alike: pairs of effects whose signatures look alike, with the cosine
    farthest, deviations, if_repeatable: as for a `Trial`, of the model without effects
    independent, unseen_independent: values that count of their own for what the model lacks, of the runs of the fit and
        of the rest; as_one: how many times fewer these are than values; noise_freedom: degrees of freedom of the
        sensors' noise, infinite where it is stated
    stated: how many calibrated parameters, drifts and gains there are, of which one stands farthest
    if_runs_drift: where that describes the data and no single effect does
    unseen_farthest, unseen_deviations: of the rest, as for a `PredictionError`
    """

    excess: float
    held_out: float
    repeatability: float
    tested: tuple[EffectScore, ...]
    trials: tuple[Trial, ...]
    combined: tuple[Trial, ...]
    alike: tuple[tuple[str, str, float], ...]
    farthest: str = ""
    deviations: float = 0.0
    if_repeatable: tuple[IfRepeatable, ...] = ()
    independent: float = 1.0
    unseen: float = float("nan")
    unseen_independent: float = 0.0
    as_one: float = 1.0
    noise_freedom: float = float("inf")
    stated: int = 1
    if_runs_drift: IfRunsDrift | None = None
    unseen_farthest: str = ""
    unseen_deviations: float = 0.0

    @property
    def freedom(self) -> Freedom:
        """Of a misfit of the runs of the fit."""
        return Freedom(self.independent, self.noise_freedom)

    @property
    def unseen_freedom(self) -> Freedom:
        """Of a misfit of the rest."""
        return Freedom(self.unseen_independent, self.noise_freedom)

    def trial_of(self, effects: tuple[str, ...]) -> Trial | None:
        return next((t for t in (*self.trials, *self.combined) if t.effects == effects), None)

    def test_of(self, effect: str) -> EffectScore | None:
        return next((t for t in self.tested if t.effect == effect), None)


def gain_over_fewer(effects: frozenset[str], gains: Mapping[frozenset[str], float]) -> float:
    """Gain of the information criterion by effects over the best known model with one of them less, which has fewer
    parameters by those of that one. gains: over the model without effects"""
    fewer = (gains[effects - {e}] for e in effects if effects - {e} in gains)
    return gains[effects] - max(fewer, default=0.0)


# `evidence.json`, every number kept to the last digit.
EVIDENCE_JSON = JsonDocument(Evidence, "updamp evidence 7", "updamp diagnose")
