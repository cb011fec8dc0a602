"""Whether the modes of a run are those that their names say, by their frequencies at the lowest force.

A mode of a study is a window with a name. Which resonances are out of phase and in phase the model says that is solved,
at forces so small that nothing slips or opens.
"""

from updamp.rig.questions import misnamed
from updamp.workflow.products import Products


def lowest_resonances(products: Products, point: str) -> dict[str, float]:
    """mode -> frequency [Hz] of its resonance at the lowest force that there is: where it is followed from, all but
    linear, else the peak of the curve at the lowest force. point: where peaks are taken"""
    found: dict[str, float] = {}
    for one in sorted((entry.product for entry in products.curves), key=lambda curve: -curve.force):
        if len(one):
            found[one.mode] = one.peak(point)[0]
    begun = {entry.product.mode: entry.product for entry in products.resonances if len(entry.product)}
    return found | {mode: float(one.frequency[0]) for mode, one in begun.items()}


def misnamed_modes(products: Products, point: str) -> list[str]:
    """Sentences."""
    return misnamed(lowest_resonances(products, point), products.named_modes)
