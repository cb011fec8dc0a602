"""The model of a test, open to change: everything that a parameter or a missing effect may alter, in one place.

An effect is a function from one `RigModel` to the next; the coupled problem is built from the last.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.effects.reading import Reading
from updamp.effects.varied_dimension import VariedDimension
from updamp.geometry.contact_elements import ContactElements, across_mid_width
from updamp.hbm.contact.law import ContactLaw
from updamp.hbm.contact.modified.modified_law import with_entries
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import LinearModel
from updamp.hbm.problem.mirror import Mirror
from updamp.hbm.problem.structural_changes import Attachment, attach, with_relative_rows
from updamp.hbm.problem.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PointElement:
    """A nonlinear element at named points, one for each of its directions, between them and the ground.

    parameters: the law's NamedTuple, each entry (1, ...)
    """

    name: str
    points: tuple[str, ...]
    law: ContactLaw
    parameters: Any


@dataclass(frozen=True, eq=False)
class RigModel:
    """components: the free components side by side, neither coupled nor supported by wires
    owner: (m,) name of the component that each of their modes belongs to
    attachments: springs, dashpots and masses at named points, the wires among them
    by_pull: names of those whose stiffness is proportional to the pull of the damper
    contacts: the friction elements, on the relative rows; None for a model without
    patches: where they lie; None where they are not laid over faces
    elements: further nonlinear elements
    excitation: name of the point that the shaker acts on; joint: of the one that effects of a joint act at, "" for the
        excitation
    places: where points and the clamps ("blade_left.root", "blade_right.root") are, name without axis -> (x, y, z)
        at rest [m]; empty where that is not known
    modes: names of identified ones, in the order of `components`
    identified: whether the modes were identified in a test rather than computed: modal masses are known roughly then
    stated_pressure: mean over the contacts at rest, as the rig file has it, whatever calibration and effects do to it
        [Pa]; None where that is not known
    reading: what is read of the motion, in comparisons with measurements
    dimensions: of the rig, by the effect that says one is wrong, with what another value of it changes; none where the
        model was built without
    turned: (m_as_built, m) the modes of `components` in those that the model was built with; None where these are they
    momentum_about_clamp: of each clamped component (m_as_built,), as `ReducedComponent` has it [kg^1/2 m], in the modes
        as built, 0 for those of others; none where that is not known
    residual_of: of each component (n_rows, n_rows) its share of the residual flexibility as built [m/N]; none where
        that is not known
    running_in: growth of the logarithm of the contacts' friction from the first run of an assembly to the last
    windows: mode -> the rig file's window of its curve [Hz]; a branch through a narrower one comes in from its ends
    """

    components: LinearModel
    owner: tuple[str, ...]
    attachments: tuple[Attachment, ...]
    contacts: ElementGroup | None
    patches: ContactElements | None
    excitation: str
    harmonics: Harmonics
    time_samples: int
    elements: tuple[PointElement, ...] = ()
    notes: Mapping[str, float] = field(default_factory=dict)
    places: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    identified: bool = False
    modes: tuple[str, ...] = ()
    stated_pressure: float | None = None
    reading: Reading = field(default_factory=Reading)
    by_pull: tuple[str, ...] = ()
    joint: str = ""
    dimensions: Mapping[str, VariedDimension] = field(default_factory=dict)
    turned: Floats | None = None
    momentum_about_clamp: Mapping[str, Floats] = field(default_factory=dict)
    residual_of: Mapping[str, Floats] = field(default_factory=dict)
    running_in: float = 0.0
    windows: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @cached_property
    def system(self) -> NonlinearSystem:
        """The coupled problem. Without harmonic 0 the mean is held, as the tables say (workflow/summary_tables.py)."""
        kept = self.harmonics, self.time_samples
        return NonlinearSystem(self.free, self.groups, *kept, self._mirror, mean_held=True)

    @cached_property
    def _mirror(self) -> Mirror | None:
        """Across the middle of the blades' width; None where the contacts are not laid over faces, or not evenly, or
        carry tangential forces at rest, whose parameters do not tell what their image is.
        """
        if self.patches is None or self.contacts is None or np.any(getattr(self.contacts.parameters, "t0", 0.0)):
            return None
        mirrored = across_mid_width(self.patches)
        if mirrored is None:
            return None
        image, sign = mirrored
        further = np.arange(3 * len(self.patches), self.free.n_relative)  # of elements at points
        rows = np.concatenate([(3 * image[:, None] + np.arange(3)).ravel(), further])
        return Mirror(rows, np.concatenate([sign.ravel(), np.ones(len(further))]))

    @property
    def rotation(self) -> Floats:
        """(m_as_built, m) `turned`, whether or not they are"""
        return np.eye(len(self.components.omega_squared)) if self.turned is None else self.turned

    @cached_property
    def free(self) -> LinearModel:
        """The structure without any contact or other element."""
        return with_relative_rows(
            attach(self.components, self.attachments), [point for e in self.elements for point in e.points]
        )

    @cached_property
    def groups(self) -> tuple[ElementGroup, ...]:
        """The contacts, then the other elements."""
        groups: list[ElementGroup] = [] if self.contacts is None else [self.contacts]
        first = self.components.n_relative
        for e in self.elements:
            groups.append(ElementGroup(e.law, e.parameters, np.arange(first, first + len(e.points))[None]))
            first += len(e.points)
        return tuple(groups)

    def excited_by(self, force: float) -> Excitation:
        """force: amplitude [N]"""
        return Excitation(self.system.free.row(self.excitation), force)

    def with_contacts(self, law: ContactLaw | None = None, **entries: Any) -> "RigModel":
        """Contacts of another law, or with other entries of the law's parameters; shapes stay.

        Entries that the parameters do not have yet are added to them: what a modified law needs.
        raises: ValueError where the model has no contacts
        """
        if self.contacts is None:
            raise ValueError("this model has no contacts whose parameters could change")
        parameters = with_entries(self.contacts.parameters, **entries)
        return replace(self, contacts=replace(self.contacts, law=law or self.contacts.law, parameters=parameters))

    def in_run(self, place: float) -> "RigModel":
        """As it was in one of an assembly's runs. place: from -1/2 for the first to 1/2 for the last, 0 for the mean of
        them; the friction of the model is that in the mean"""
        if self.running_in == 0 or self.contacts is None:
            return self
        friction = self.contacts.parameters.mu * np.exp(self.running_in * place)
        return replace(self.with_contacts(mu=friction), running_in=0.0)

    def with_pull(self, factor: float) -> "RigModel":
        """Under another pull, times the present one: the preload of the contacts, and what the tension gives the wires
        sideways and against roll.

        raises: ValueError where the model has no contacts
        """
        attachments = tuple(
            replace(a, stiffness=a.stiffness * factor) if a.name in self.by_pull else a for a in self.attachments
        )
        preload = None if self.contacts is None else self.contacts.parameters.n0 * factor
        return replace(self.with_contacts(n0=preload), attachments=attachments)
