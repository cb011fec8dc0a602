"""When contacts would begin to slip in OOP and to open in IP, by the linear motion.

At the resonance of the stuck structure, with what pressure the design has. Neither damping nor the shaker's height
enters.
"""

import numpy as np

from updamp.design.solved_design import SolvedDesign
from updamp.hbm.resonance.conditions import linear_peak
from updamp.hbm.resonance.resonance import ResonanceProblem


def tip_at_onset(design: SolvedDesign, mode: str) -> float:
    """Amplitude of the tip [mm] at which half of the patches slip (OOP) or a quarter of them open (IP)."""
    system, tracked, rig = design.model.system, design.mode(mode), design.geometry
    row, tip = system.free.row(design.model.excitation), system.free.row(design.observed)
    peak = linear_peak(ResonanceProblem(system, row, tip), tracked.window, 0.0, tracked.frequency)
    motion = np.abs(system.harmonics.amplitude(peak.z, 1).reshape(-1, 3))
    rows = np.array([tip, row])
    receptance = abs(system.stuck.receptance(peak.w, rows[:1], rows[1:])[0, 0])
    contact = rig.contact
    pressure = design.rest.normal_force.sum() / (2 * rig.face_area)
    if mode == "OOP":
        slip = contact.friction_coefficient * pressure / contact.tangential_stiffness
        return float(1e3 * receptance * np.median(slip / np.hypot(motion[:, 0], motion[:, 1])))
    return float(1e3 * receptance * np.quantile(pressure / contact.normal_stiffness / motion[:, 2], 0.25))
