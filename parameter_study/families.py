"""What a parameter study consists of: variants of one rig, and families of their response curves."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from updamp.fem.contact_places import ContactPlace
from updamp.workflow.curve_jobs import CurveJob


@dataclass(frozen=True)
class Variant:
    """The rig with some of its values replaced. changes: by dotted path, as `load_any` takes them"""

    name: str
    changes: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class CurveName:
    """force: amplitude of the excitation [N]"""

    variant: str
    mode: str
    force: float

    @property
    def label(self) -> str:
        return f"{self.variant}, {self.mode} {self.force:g} N"


@dataclass(frozen=True)
class StudyCurveJob(CurveJob):
    """Of a curve; begun in the order in which the study names them. variant: it belongs to; place: in that order"""

    variant: str = ""
    place: int = 0

    @property
    def name(self) -> str:
        return CurveName(self.variant, self.mode, self.force).label

    @property
    def ease(self) -> tuple[float, ...]:
        return (float(self.place),)


def in_study(job: CurveJob, variant: str, place: int) -> StudyCurveJob:
    return StudyCurveJob(**{f.name: getattr(job, f.name) for f in fields(CurveJob)}, variant=variant, place=place)


@dataclass(frozen=True)
class Family:
    """Curves that are looked at together: each variant in each mode at each force [N].

    pictures: names of what is drawn of them (parameter_study/family_pictures.py)
    """

    name: str
    title: str
    variants: tuple[str, ...]
    modes: tuple[str, ...]
    forces: tuple[float, ...]
    pictures: tuple[str, ...]

    def curves(self) -> Iterator[CurveName]:
        for mode in self.modes:
            for force in self.forces:
                for variant in self.variants:
                    yield CurveName(variant, mode, force)


@dataclass(frozen=True)
class MeasuredResonance:
    """Of a test, to be drawn beside the curves. force: [N]; frequency: [Hz]"""

    mode: str
    force: float
    frequency: float


@dataclass(frozen=True)
class ParameterStudy:
    """rig, out: file and folder; mesh: preset; jobs: None where the file does not say; findings: "" for none
    the rest as in the file, resolved"""

    name: str
    rig: Path
    mesh: str
    out: Path
    jobs: int | None
    findings: str
    variants: tuple[Variant, ...]
    families: tuple[Family, ...]
    contacts: tuple[ContactPlace, ...]
    measured: tuple[MeasuredResonance, ...]
