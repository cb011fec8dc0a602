"""The same rig on the same mesh, solved by updamp and by the virtual laboratory, each by its own code."""

import numpy as np
from support.plain_rig import TINY

from updamp.benchmarks.virtual_rig.assembled import assembled
from updamp.benchmarks.virtual_rig.bench import Bench
from updamp.benchmarks.virtual_rig.periodic import SolverOptions
from updamp.benchmarks.virtual_rig.stepped_sine import StepMotor
from updamp.effects.rig_model import RigModel
from updamp.fem.finite_element_model import finite_element_model
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.hbm.newton import observe
from updamp.hbm.newton.equation import linear_solution
from updamp.hbm.newton.newton import solve
from updamp.model.build import rig_model
from updamp.rig.rig import Rig

# The law that takes its events at the samples, as the laboratory does.
CHANGES = {"mesh.tiny": TINY, "contact.law": "jenkins_box_sampled", "harmonic_balance.time_samples": 256}
OPTIONS = SolverOptions(3, 256, 1e-9)
SIDES = ("left", "right")


def built(rig: Rig) -> RigModel:
    reduced = finite_element_model(build_mesh(rig, "tiny"), rig).reduced
    return rig_model(reduced, static_contact(reduced, rig), rig)


def in_laboratory(bench: Bench, frequency: float, force: float) -> np.ndarray:
    motion = StepMotor(assembled(bench), OPTIONS).step(frequency, force)
    return np.array([motion.response(f"blade_{side}.tip.x")[0] for side in SIDES])


def by_updamp(model: RigModel, frequency: float, force: float, start: np.ndarray | None = None):
    """start: motion of the contacts to begin from, without the elements and harmonics that an effect adds"""
    w, excitation = 2 * np.pi * frequency, model.excited_by(force)
    x = linear_solution(model.system, w, excitation)
    if start is not None:
        x[: len(start), -start.shape[1] :] = start
    solution = solve(model.system, excitation, x, w)
    assert solution.converged
    rows = np.array([model.system.free.row(f"blade_{side}.tip.x") for side in SIDES])
    response = observe.response(solution.equation, excitation, rows)
    return np.array([model.system.harmonics.amplitude(r, 1) for r in response]), solution.x
