"""A rig's model, ready to be solved."""

from dataclasses import dataclass, replace
from html import escape

from updamp.effects.catalogue import catalogue
from updamp.effects.chosen import ChosenEffect
from updamp.effects.effect import Effect
from updamp.effects.placed import effect_called
from updamp.effects.rig_model import RigModel
from updamp.hbm.problem.system import NonlinearSystem
from updamp.report.markup import number, table
from updamp.rig.modal_rig import ModalRig
from updamp.rig.rig import Rig

_FREQUENCIES = 6  # shown


@dataclass(frozen=True, eq=False, repr=False)
class Model:
    """Blades, damper and contacts as one nonlinear system, or the modes of a test; calibration and effects applied.

    rig: what it was built from; mesh: preset, "" for a rig given by modes
    parts: components, attachments, contacts, elements (`effects/rig_model.py`)
    effects: names of those in it, in the order in which they were applied
    """

    rig: Rig | ModalRig
    mesh: str
    parts: RigModel
    effects: tuple[str, ...]

    @property
    def system(self) -> NonlinearSystem:
        """The coupled equations, as the solvers of `hbm/` take them."""
        return self.parts.system

    @property
    def points(self) -> tuple[str, ...]:
        """Names of the points whose displacement can be asked for, such as "blade_right.tip.x"."""
        return tuple(self.system.free.points)

    @property
    def response_point(self) -> str:
        """Where responses are taken unless a point is named: the tip of the excited blade; the excitation of modes."""
        return self.rig.response_point

    @property
    def stuck_frequencies(self) -> tuple[float, ...]:
        """Of the undamped modes with every contact closed and stuck, rising [Hz]"""
        return tuple(float(f) for f in self.system.stuck.frequencies)

    @property
    def modes(self) -> dict[str, tuple[float, float]]:
        """Name -> window in which a response curve of that mode is traced [Hz]: that of the rig file's study, or 5 % to
        both sides of a mode that the rig file states."""
        return self.rig.windows

    def with_effect(self, effect: str | Effect, **values: float) -> "Model":
        """The model with one more effect, to see what it would do; no file changes.

        effect: name in the catalogue, or an effect of your own; values: in the units of its parameters, SI; one that
            is left out stays at the value at which the effect is absent
        raises: ValueError naming an effect, parameter or value that cannot be, or one that the model has no place for
        """
        chosen = ChosenEffect(*_checked(effect, values))
        return replace(self, parts=chosen.apply(self.parts), effects=(*self.effects, chosen.effect.name))

    def __repr__(self) -> str:
        return f"<Model {', '.join(f'{name} {value}' for name, value in self._rows())}>"

    def _repr_html_(self) -> str:
        return table(("", ""), [(escape(name), escape(value)) for name, value in self._rows()], numbers_from=2)

    def _rows(self) -> list[tuple[str, str]]:
        frequencies = ", ".join(number(f, 5) for f in self.stuck_frequencies[:_FREQUENCIES])
        contacts = self.parts.contacts
        return [
            ("rig", self.rig.name),
            *([("mesh", self.mesh)] if self.mesh else []),
            *([("contact elements", str(len(contacts.rows)))] if contacts is not None else []),
            ("harmonics", ", ".join(map(str, self.parts.harmonics.orders))),
            ("stuck frequencies [Hz]", frequencies),
            ("effects", ", ".join(self.effects) or "none"),
            ("calibration", ", ".join(self.rig.calibration.factors) or "none"),
        ]


def _checked(effect: str | Effect, values: dict[str, float]) -> tuple[Effect, dict[str, float]]:
    """raises: ValueError naming what cannot be, with what would be allowed"""
    if isinstance(effect, str):
        found = effect_called(effect)
        if found is None:
            raise ValueError(f'effect = "{effect}": not in the catalogue; there are {", ".join(catalogue())}')
        effect = found
    usual = ", ".join(f"{p.name} = {p.typical:g}" for p in effect.parameters)
    if not values:
        raise ValueError(f'the effect "{effect.name}" needs values in SI units, such as {usual}')
    bounds = {p.name: (p.lower, p.upper, p.unit) for p in effect.parameters}
    for name, value in values.items():
        if name not in bounds:
            raise ValueError(f'{name} = {value!r}: no parameter of "{effect.name}"; typical values are {usual}')
        lower, upper, unit = bounds[name]
        if not lower <= value <= upper:
            raise ValueError(f"{name} = {value!r}: out of range: allowed is {lower:g} to {upper:g} {unit}".rstrip())
    return effect, {**effect.at_null(), **values}
