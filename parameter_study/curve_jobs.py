"""Curves of a parameter study as jobs: begun in the order in which the study names them."""

from dataclasses import dataclass, fields

from updamp.parameter_study.families import CurveName
from updamp.workflow.curve_jobs import CurveJob


@dataclass(frozen=True)
class StudyCurveJob(CurveJob):
    """variant: it belongs to; place: in the study's order"""

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
