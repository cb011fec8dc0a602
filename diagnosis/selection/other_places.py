"""Effects of a joint that leave a misfit at the excitation, at the other points of a model of several modes."""

from collections.abc import Sequence

from updamp.diagnosis.candidate_models.candidate_fits import CandidateFits, FitContext, best_first
from updamp.diagnosis.candidate_models.fit_tasks import FitTask
from updamp.effects.effect import Effect
from updamp.effects.placed import at_other_places
from updamp.effects.sized import sized


def try_other_places(fits: FitContext, effects: Sequence[Effect], singles: CandidateFits) -> CandidateFits:
    """Fits of those of the best effects that leave less there, where the model may lack something and none explains
    the data: two effects at a wrong place may stand in for one at the right one.

    effects: as in the catalogue
    """
    start, criteria = fits.start, fits.criteria
    base = start.fitted.parametrisation.base
    lacking = criteria.is_doubtful(start.fitted.compared.mean_squared_misfit, start.freedom)
    if not lacking or any(fits.explains(r.trial) for r in singles.values()):
        return {}
    best = [r.refit.effects[0].name for r in best_first(singles) if r.trial.full][: criteria.search.full]
    tried = at_other_places([e for e in effects if e.name in best], base)
    amplitude = start.train_plan.largest_amplitude
    found = fits.results([FitTask((sized(effect, base, amplitude),), (), full=True) for effect in tried])
    return {names: r for names, r in found.items() if r.trial.excess < singles[(r.refit.effects[0].kind,)].trial.excess}
