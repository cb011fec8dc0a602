"""The stages of a run, what each depends on, and the keys that tell whether one has to run again.

A stage's key is the hash of the sections of the rig file that it reads, of its version, and of the keys of the
stages before it. Nothing else enters: a stage that would get the same input is not run again.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

# No module of updamp is imported here: the command line reads this table before it says how many threads numpy, which
# those load, is to use.


class StatedRig(Protocol):
    """What a stage has to know of `updamp.rig.rig.Rig`."""

    def digest(self, *keys: str) -> str: ...

    def states(self, key: str) -> bool: ...


@dataclass(frozen=True)
class Stage:
    """One stage.

    version: to be raised whenever the stage computes something else from the same input
    sections: dotted paths in the rig file; {preset} and {mode} stand for the choices of the run
    optional: further ones, which enter where the file states something there: keys from before they existed still hold
    choices: what else distinguishes one product from another: "force" is the excitation's amplitude
    after: the stages whose products it takes
    instead: (section, the one that enters in its place where the file states something there), for the same reason
    part_of: stages of whose products it takes a part alone: what that depends on stands among its own sections, and
        only the versions of these stages enter
    """

    name: str
    version: int
    sections: tuple[str, ...]
    after: tuple["Stage", ...] = ()
    choices: tuple[str, ...] = ()
    optional: tuple[str, ...] = ()
    instead: tuple[tuple[str, str], ...] = ()
    part_of: tuple["Stage", ...] = ()

    def key(self, rig: StatedRig, choice: Mapping[str, str]) -> str:
        """SHA-256 of all that goes into the product, hexadecimal.

        choice: values of "preset", "mode" and "force", as far as this stage and those before it use them
        """
        ingredients = {
            "stage": self.name,
            "version": self.version,
            "rig": rig.digest(*self.read(rig, choice)),
            "choices": {name: choice[name] for name in self.choices},
            "after": [stage.key(rig, choice) for stage in self.after],
            "part_of": [(stage.name, stage.version) for stage in self.part_of],
        }
        return hashlib.sha256(json.dumps(ingredients, sort_keys=True).encode()).hexdigest()

    def read(self, rig: StatedRig, choice: Mapping[str, str]) -> tuple[str, ...]:
        """The sections that enter for this rig. choice: as `key`"""
        instead = {section: own for section, own in self.instead if rig.states(own)}
        sections = (instead.get(section, section).format(**choice) for section in self.sections)
        optional = (section.format(**choice) for section in self.optional)
        return (*sections, *(section for section in optional if rig.states(section)))


# --- the one table of what depends on what ---

MESH = Stage(
    name="mesh",
    version=2,
    sections=("blade", "platform", "damper", "excitation.height", "response", "mesh.{preset}"),
)

_MATERIAL = ("material.youngs_modulus", "material.poissons_ratio", "material.density")
_ELASTIC = (
    *_MATERIAL,
    "contact.coupling",
    "reduction",
)
# The faces where both meet, and the contact elements over them; the width is common too.
_FACES = (
    "blade.width",
    "platform",
    "damper.face_start",
    "damper.face_length",
    "mesh.{preset}.width",
    "mesh.{preset}.face",
    "mesh.{preset}.contact_elements",
)
_STRIPS = "mesh.{preset}.contact_strips"
BLADE = Stage(
    name="blade",
    version=2,
    sections=(
        *_ELASTIC,
        *_FACES,
        "blade",
        "excitation.height",
        "response",
        "mesh.{preset}.platform_outer",
        "mesh.{preset}.platform_inner",
        "mesh.{preset}.platform_height",
        "mesh.{preset}.stem_thickness",
        "mesh.{preset}.stem_below_excitation",
        "mesh.{preset}.stem_below_platform",
        "mesh.{preset}.stem_above_platform",
        "mesh.{preset}.stem_top",
    ),
    optional=(_STRIPS,),
    part_of=(MESH,),
)
DAMPER = Stage(
    name="damper",
    version=2,
    sections=(
        *_ELASTIC,
        *_FACES,
        "damper",
        "mesh.{preset}.damper_across",
        "mesh.{preset}.damper_apex",
        "mesh.{preset}.damper_base",
    ),
    optional=(_STRIPS,),
    instead=tuple((section, f"damper.{section}") for section in _MATERIAL),
    part_of=(MESH,),
)
# Both put together: a moment's work.
FINITE_ELEMENTS = Stage(name="finite_elements", version=3, sections=(), after=(BLADE, DAMPER))
COUPLED_CHECK = Stage(
    name="coupled_check",
    version=1,
    sections=("contact.tangential_stiffness", "contact.normal_stiffness", "wire", "load"),
    after=(FINITE_ELEMENTS,),
)
STATIC_CONTACT = Stage(
    name="static_contact",
    version=1,
    sections=("load", "contact.friction_coefficient", "contact.pressure"),
    after=(FINITE_ELEMENTS,),
)
CURVE = Stage(
    name="curve",
    version=20,
    sections=(
        "damper_model",
        "material.loss_factor",
        "wire",
        "load",
        "excitation.blade",
        "contact.law",
        "contact.friction_coefficient",
        "contact.tangential_stiffness",
        "contact.normal_stiffness",
        "harmonic_balance",
        "study.modes.{mode}",
    ),
    after=(STATIC_CONTACT,),
    choices=("force",),
    optional=("effects", "calibration", "damper.material.loss_factor"),
)

# A mode's resonance followed in the force, through all levels of the study; what goes into a curve goes into it.
RESONANCE = Stage(
    name="resonance",
    version=11,
    sections=(*CURVE.sections, "excitation", "study.force_levels"),
    after=(STATIC_CONTACT,),
    optional=CURVE.optional,
)

# The same at some forces alone, as a design study asks for it.
PEAKS = Stage(
    name="peaks",
    version=2,
    sections=(*CURVE.sections, "excitation"),
    after=(STATIC_CONTACT,),
    choices=("point", "forces", "frequency", "points"),
    optional=CURVE.optional,
    part_of=(RESONANCE,),
)

STABILITY = Stage(name="stability", version=9, sections=(), after=(CURVE,), choices=("force",))

# Branches at the curve's force that are no part of it; the resonance followed in force may lead to some.
DETACHED = Stage(name="detached", version=2, sections=(), after=(CURVE,), choices=("force",))

# A few periods from the peak, marched in time.
MARCHED_PEAK = Stage(name="marched_peak", version=1, sections=(), after=(CURVE,), choices=("force",))

# Only where a run says how accurate it is.
FINER_POINTS = Stage(name="finer_points", version=1, sections=(), after=(CURVE,), choices=("force",))
FINER_CURVE = Stage(name="finer_curve", version=1, sections=(), after=(CURVE,), choices=("force",))

STAGES = (MESH, BLADE, DAMPER, FINITE_ELEMENTS, COUPLED_CHECK, STATIC_CONTACT, CURVE)
