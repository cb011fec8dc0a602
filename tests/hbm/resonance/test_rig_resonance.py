"""The resonance out of phase of a rig with short faces (small mesh, 36 contacts): the observed tip moves against the
force, and faces open one after another, in kinks in which the force turns round.
"""

from pathlib import Path

import numpy as np
import pytest

from updamp.fem.finite_element_model import finite_element_model
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.hbm.continuation.curve import CurveRequest, trace
from updamp.hbm.resonance.conditions import PhaseResonance
from updamp.hbm.resonance.quadrature import quadrature_resonances
from updamp.hbm.resonance.resonance_curve import ResonanceRequest, trace_resonance
from updamp.model.build import rig_model
from updamp.model.rig_files import load_rig

RIG_FILE = Path(__file__).parents[2] / "data" / "short_faces.toml"
FORCES = (3.84, 9.6, 17.0)


@pytest.fixture(scope="module")
def rig():
    return load_rig(RIG_FILE)


@pytest.fixture(scope="module")
def model(rig):
    reduced = finite_element_model(build_mesh(rig, "small"), rig).reduced
    return rig_model(reduced, static_contact(reduced, rig), rig)


@pytest.fixture(scope="module", params=[-np.pi / 2, np.pi / 2], ids=["behind", "ahead"])
def followed(rig, model, request):
    """Whichever sign is asked for."""
    blade, window = f"blade_{rig.excitation.blade}", rig.study.modes["OOP"].window
    condition = PhaseResonance(request.param)
    asked = ResonanceRequest("OOP", f"{blade}.excitation.x", f"{blade}.tip.x", window, FORCES, condition)
    *_, curve = trace_resonance(model.system, asked)
    return curve


def test_it_is_followed_through_kinks_within_its_window_whichever_sign_is_asked_for(followed):
    assert followed.complete, followed.stopped
    assert (np.abs(followed.frequency - 444.0) < 4.0).all()
    assert (np.angle(followed.amplitude()) > 0).all()


def test_it_is_that_of_the_response_curve(rig, model, followed):
    tip, window = f"blade_{rig.excitation.blade}.tip.x", rig.study.modes["OOP"].window
    *_, curve = trace(model.system, CurveRequest("OOP", model.excited_by(9.6), window, (tip,)))
    (found,) = quadrature_resonances(curve, tip)
    at = followed.at_forces()
    assert found.frequency == pytest.approx(at.frequency[1], abs=0.05)
    assert found.receptance == pytest.approx(abs(at.receptance[1]), rel=0.005)
