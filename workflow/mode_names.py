"""Whether the windows of a run hold the modes that their names say, before curves are traced and after.

A mode of a study is a window with a name. Which resonances are out of phase and in phase the model says that is solved,
at forces so small that nothing slips or opens.
"""

from collections.abc import Mapping

import numpy as np

from updamp.fem.reduced_model import ReducedModel
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.model.build import rig_model
from updamp.model.small_amplitude import modes_by_name
from updamp.rig.questions import empty_windows, misnamed, possible_resonances, undivided_windows
from updamp.rig.rig import Rig
from updamp.workflow.products import Products


def named_modes(rig: Rig, reduced: ReducedModel, rest: StaticContact) -> dict[str, float]:
    """As `modes_by_name`; raises: ValueError naming an effect or factor that the rig has no place for"""
    near = float(np.mean([mode.window for mode in rig.study.modes.values()]))
    return modes_by_name(rig_model(reduced, rest, rig), near)


def window_questions(windows: Mapping[str, tuple[float, float]], products: Products) -> list[str]:
    """windows: of the modes whose curves are wanted [Hz]; what can lie in none is known where the coupled check is"""
    check, empty = products.coupled_check, []
    if check is not None and products.finite_elements is not None:
        free, stuck = products.finite_elements.product.blade_frequencies.tolist(), check.product.full.tolist()
        empty = empty_windows(windows, possible_resonances(free, stuck), max(stuck))
    return [*empty, *undivided_windows(windows, products.named_modes)]


def lowest_resonances(products: Products, point: str) -> dict[str, float]:
    """mode -> frequency [Hz] of its resonance at the lowest force that there is: where it is followed from, all but
    linear, else the peak of the curve at the lowest force. Of a curve that is not complete the largest response may be
    no resonance, such as an end of the window: nothing is said of it here (the run says why it is not complete).
    point: where peaks are taken"""
    lowest: dict[str, ResponseCurve] = {}
    for one in sorted((entry.product for entry in products.curves), key=lambda curve: -curve.force):
        lowest[one.mode] = one
    peaks = {mode: one.peak(point)[0] for mode, one in lowest.items() if one.complete and len(one)}
    begun = {entry.product.mode: entry.product for entry in products.resonances if len(entry.product)}
    return peaks | {mode: float(one.frequency[0]) for mode, one in begun.items()}


def misnamed_modes(products: Products, point: str) -> list[str]:
    """Sentences."""
    return misnamed(lowest_resonances(products, point), products.named_modes)
