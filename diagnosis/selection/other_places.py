"""Effects of a joint that leave a misfit at the excitation, at the other points of a model of several modes."""

from collections.abc import Sequence

from updamp.diagnosis.candidate_models.candidate_fits import CandidateFits, FitContext, best_first
from updamp.diagnosis.candidate_models.fit_tasks import FitTask
from updamp.effects.effect import Effect
from updamp.effects.placed import at_other_places
from updamp.effects.sized import sized


def try_other_places(fits: FitContext, effects: Sequence[Effect], singles: CandidateFits) -> CandidateFits:
    """Fits of those of the best effects that leave less there, where the model may lack something or the data ask for
    an effect: at a wrong place another law, or two, may stand in for the right one.

    effects: as in the catalogue
    """
    start = fits.start
    base = start.fitted.parametrisation.base
    settled = [r.refit for r in best_first(singles) if r.trial.full]
    if not fits.may_lack_something(settled):
        return {}
    best = [r.effects[0].name for r in settled[: fits.criteria.search.full]]
    tried = at_other_places([e for e in effects if e.name in best], base, {c.mode for c in start.train_plan.conditions})
    amplitude = start.train_plan.largest_amplitude
    found = fits.results([FitTask((sized(effect, base, amplitude),), (), full=True) for effect in tried])
    return {names: r for names, r in found.items() if r.trial.excess < singles[(r.refit.effects[0].kind,)].trial.excess}
