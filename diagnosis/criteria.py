"""What the search for a missing effect decides by. All of it is fixed before a benchmark is scored.

The mean squared misfit is chi-square over the number of measured values: 1 is what the scatter leaves.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Criteria:
    """score, visibility: of the score test, below which an effect is not looked for in the data
    short, full: how many effects at most get a short refit, and a full one
    close: mean squared misfit after a short refit, over that of the best one, up to which an effect gets a full one
    nearly: share of the best effect's fall of mean squared misfit from which on another one is fitted in full too, and
        the next one has second effects looked for beside it
    comparable: mean squared misfit, over that of the best one, beyond which it does not count as nearly as good
    promising: share of the misfit left by a short refit from where on the full one is done before others are tried
    delta_bic: by which an effect has to improve the information criterion, the misfit that is left taken as noise
    gain: share by which the error on held-out runs has to fall
    calibration: prior deviations of a nuisance parameter, drift or gain from what is stated, from where on that is said
        first and nothing is named or called adequate: one in 370 is as far off by chance
    at_bound: distance from a bound, as a share of its range, within which a parameter stands at it
    as_good: an effect explains the data as well as the best one where its mean squared misfit is no more than this
        share above the best
    cosine: of two signatures above which the effects look alike
    cosine_to_refit: to the signature of one that explains the data, from where on another one is fitted too
    lack: mean squared misfit from where on a model fails that no effect has improved
    excess: mean squared misfit above which a model with effects still fails
    unseen: weighted residual RMS on held-out runs above which a model with effects still fails
    look_further: mean squared misfit above which a second effect is looked for
    second: share that a second effect has to bring the mean squared misfit down to
    """

    score: float = 4.0
    visibility: float = 0.2
    short: int = 6
    full: int = 3
    close: float = 1.6
    nearly: float = 0.8
    comparable: float = 4.0
    promising: float = 0.2
    delta_bic: float = 10.0
    gain: float = 0.03
    calibration: float = 3.0
    at_bound: float = 0.005
    as_good: float = 0.1
    cosine: float = 0.9
    cosine_to_refit: float = 0.5
    lack: float = 1.6
    excess: float = 1.7
    unseen: float = 1.5
    look_further: float = 1.25
    second: float = 0.85
