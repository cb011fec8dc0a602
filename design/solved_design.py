"""One design, solved as far as its responses ask: stages from the common folder, resonances and curves on demand."""

from collections import deque
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar

from updamp.design.rig_numbers import AnyRig
from updamp.design.shared_stages import SharedStages, given_up
from updamp.design.solved_peak import (
    CURVE,
    RESONANCE_ONLY,
    FollowedPeaks,
    PeakRequest,
    SolvedPeak,
    followed_peaks,
    peak_of_curve,
    resonance_request,
)
from updamp.design.tracked_modes import ModeReference, TrackedMode, UnknownResponseError, tracked_mode
from updamp.effects.rig_model import RigModel
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.hbm.continuation.curve import CurveRequest, trace
from updamp.hbm.continuation.curve_records import observed_points
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.model.build import modal_model, rig_model
from updamp.model.rig_files import load_any
from updamp.rig.modal_rig import ModalRig
from updamp.rig.rig import Rig
from updamp.workflow.curve_jobs import CurveJob

T = TypeVar("T")


@dataclass(frozen=True)
class DesignInput:
    """rig: file; changes: by dotted path, as `load_any` takes them; mesh: preset; store: common folder of the stages
    references: the study's modes; peaks: all that the responses will ask for, so that each resonance is followed once
    most_points: of one resonance followed in the force, and of one whole curve; what takes more is not known
    """

    rig: Path
    changes: Mapping[str, Any]
    mesh: str
    store: Path
    references: tuple[ModeReference, ...] = ()
    peaks: tuple[PeakRequest, ...] = ()
    most_points: int | None = None


@dataclass(eq=False)
class SolvedDesign:
    """Nothing is computed before it is asked for, nothing twice: what failed raises the same error again.

    executed: stages that were computed; routes: which way each peak was found, and why not the other
    """

    given: DesignInput
    executed: list[str] = field(default_factory=list)
    routes: dict[PeakRequest, str] = field(default_factory=dict)
    _kept: dict[Hashable, Any] = field(default_factory=dict)

    @property
    def rig(self) -> AnyRig:
        """raises: RigError where it cannot be built"""
        return self._once("rig", lambda: load_any(self.given.rig, dict(self.given.changes)))

    @property
    def geometry(self) -> Rig:
        """raises: UnknownResponseError for a rig given by modes"""
        if not isinstance(self.rig, Rig):
            raise UnknownResponseError("a rig given by modes has no geometry; take another response")
        return self.rig

    @property
    def model(self) -> RigModel:
        """raises: what the stages raise; ValueError for an effect that the rig has no place for"""
        return self._once("model", self._built)

    @property
    def observed(self) -> str:
        """Where responses are taken unless a point is named."""
        return self.rig.response_point

    @property
    def rest(self) -> StaticContact:
        """Of a rig with geometry. raises: what the stages raise"""
        return self._once("rest", lambda: self._stages(self.geometry).static_contact())

    def mode(self, name: str) -> TrackedMode:
        """raises: UnknownResponseError where the mode is not recognised"""
        reference = next(one for one in self.given.references if one.name == name)
        return self._once(("mode", name), lambda: tracked_mode(self.model.system.stuck, reference))

    def peak(self, request: PeakRequest) -> SolvedPeak:
        """raises: UnknownResponseError with the reasons of both ways"""
        if request.by == CURVE:
            self.routes[request] = CURVE
            return peak_of_curve(self.curve(request.mode, request.force), request.point or self.observed)
        followed, stopped = self._followed(request.mode, request.point)
        if followed is not None and (peak := followed.at(request.force)) is not None:
            self.routes[request] = peak.by
            return peak
        if request.by == RESONANCE_ONLY or (followed is not None and followed.given_up):
            raise UnknownResponseError(stopped)
        self.routes[request] = f"{CURVE}, since {stopped}"
        try:
            return peak_of_curve(self.curve(request.mode, request.force), request.point or self.observed)
        except UnknownResponseError as error:
            raise UnknownResponseError(f"{stopped}; and {error}") from None

    def curve(self, mode: str, force: float) -> ResponseCurve:
        """The whole response curve through the mode's window, as far as it could be followed [N]."""
        return self._once(("curve", mode, force), lambda: self._traced(mode, force))

    def _followed(self, mode: str, point: str) -> tuple[FollowedPeaks | None, str]:
        """All forces of the study in this mode at once, and why the last was not reached ("" where it was)."""
        wanted = {p.force for p in self.given.peaks if (p.mode, p.point) == (mode, point) and p.by != CURVE}

        def follow() -> tuple[FollowedPeaks | None, str]:
            stuck, most = self.mode(mode), self.given.most_points
            request = resonance_request(self.model, mode, point or self.observed, stuck, sorted(wanted), most)
            try:
                if isinstance(self.rig, ModalRig):
                    found = followed_peaks(self.model, request)
                else:
                    found = self._stages(self._moved(mode, stuck.window)).peaks(self.model, request)
            except ValueError as error:  # no mode in the window
                return None, str(error)
            return found, found.met.stopped

        return self._once(("followed", mode, point), follow)

    def _built(self) -> RigModel:
        if isinstance(self.rig, ModalRig):
            return modal_model(self.rig)
        stages = self._stages(self.rig)
        return rig_model(stages.finite_elements().reduced, stages.static_contact(), self.rig)

    def curve_job(self, mode: str, force: float, window: tuple[float, float] | None = None) -> CurveJob:
        """What traces the curve [N] of a rig with geometry through the window, by default that where the mode is now.

        raises: what the stages before raise; UnknownResponseError where the mode is not recognised
        """
        assert self.model is not None, "the stages before are made with the model"
        return self._stages(self._moved(mode, window or self.mode(mode).window)).curve_job(mode, force)

    def _moved(self, mode: str, window: tuple[float, float]) -> Rig:
        """The rig with another window of a mode."""
        moved = load_any(self.given.rig, {**self.given.changes, **window_change(mode, window)})
        assert isinstance(moved, Rig), "of the same kind as before"
        return moved

    def _traced(self, mode: str, force: float) -> ResponseCurve:
        most = self.given.most_points
        if not isinstance(self.rig, ModalRig):
            return self._stages(self._moved(mode, self.mode(mode).window)).curve(mode, force, most)
        points, told = observed_points(self.model.system.free), (self.rig.response_point,)
        request = CurveRequest(mode, self.model.excited_by(force), self.mode(mode).window, points, told=told)
        (curve,) = deque(islice(trace(self.model.system, request), most), maxlen=1)
        return curve if curve.complete or curve.stopped else replace(curve, stopped=given_up(len(curve)))

    def _stages(self, rig: Rig) -> SharedStages:
        return SharedStages(rig, self.given.mesh, self.given.store, executed=self.executed)

    def _once(self, key: Hashable, compute: Callable[[], T]) -> T:
        if key not in self._kept:
            try:
                self._kept[key] = compute(), None
            except Exception as error:
                self._kept[key] = None, error
        value: T
        value, failure = self._kept[key]
        if failure is not None:
            raise failure
        return value


def window_change(mode: str, window: Sequence[float]) -> dict[str, list[str]]:
    """As it replaces the mode's window in a rig file."""
    return {f"study.modes.{mode}.window": [f"{edge:.7g} Hz" for edge in window]}
