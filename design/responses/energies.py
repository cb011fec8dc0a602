"""Where the work of the excitation goes at a resonance."""

from updamp.design.responses.response import AtPeak, response
from updamp.design.solved_design import SolvedDesign
from updamp.hbm.newton.observe import friction_share


@response("energy_ratio")
class EnergyRatio(AtPeak):
    """Friction loss over the work of the excitation, a cycle; the rest is lost in the material."""

    def value(self, design: SolvedDesign) -> float:
        peak = self.peak(design)
        return friction_share(peak.friction_loss, peak.work_in)
