"""What a comparison says: which reading of the misfit it goes by."""

from collections.abc import Mapping, Sequence

from updamp.comparison.comparison import Backbone, Finding
from updamp.comparison.findings.direction import Misfit
from updamp.comparison.findings.findings import findings
from updamp.comparison.findings.gross_misfit import linear_findings
from updamp.comparison.findings.peak_misfit import peak_misfits, without_peak
from updamp.comparison.findings.peak_sentences import peak_findings, without_peak_findings
from updamp.comparison.findings.several_peaks import several_peaks, several_peaks_findings
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.scatter import Scatter
from updamp.comparison.prediction.predicted_branch import PredictedBranch


def all_findings(
    fit: Fit,
    plan: Plan,
    branches: Sequence[PredictedBranch],
    first_order: Sequence[Misfit],
    names: Mapping[str, str],
    measured: Sequence[Backbone],
    model: Sequence[Backbone],
    repeats: Scatter,
) -> tuple[Finding, ...]:
    """Sentences on what stands out of the scatter, none where the model is adequate.

    With contacts, the peaks are read: frequency, height, sensors against each other. What they do not show is looked
    for along the whole curves, to first order, and then in chi2 alone. Peaks are held against what the repeats alone
    scatter by: where the model fails, the fit takes some of that for scatter. Without contacts there is no damping but
    the material's, and the phase tells it.

    branches: calibrated, one a condition; first_order: `misfits`; names: of the channels, by point
    measured, model: backbones, as for `linear_findings`; repeats: `of_repeats`
    """
    if fit.parametrisation.base.contacts is None:
        return linear_findings(fit, plan, branches, first_order, measured, model)
    more = several_peaks(fit, plan, branches)
    of_others = {one.test for one in more}
    read = [m for m in peak_misfits(fit, plan, branches, repeats) if m.direction.test not in of_others]
    missing = [test for test in without_peak(plan, branches) if test not in of_others]
    told = (*several_peaks_findings(more, plan), *without_peak_findings(missing, plan))
    return (*told, *peak_findings(read, plan, names)) or findings(fit, plan, first_order)
