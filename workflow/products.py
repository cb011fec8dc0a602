"""What a run's stages have given, each with its file and stamp."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Generic, TypeVar

from updamp.fem.finite_element_model import ComponentModel, CoupledCheck, FiniteElementResult
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.geometry.rig_mesh import RigMesh
from updamp.hbm.analysis.finer_points import PointErrors
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.resonance.resonance_curve import ResonanceCurve
from updamp.hbm.stability.branch_stability import BranchStability
from updamp.hbm.stability.detached_branches import DetachedBranches
from updamp.hbm.time_marching.marched_peak import MarchedPeak
from updamp.workflow import store
from updamp.workflow.job_pool import Job, JobOutcome

Product = TypeVar("Product")


@dataclass(frozen=True, eq=False)
class Stored(Generic[Product]):
    """A stage's product with its file and stamp."""

    path: Path
    product: Product
    stamp: store.Stamp


@dataclass(frozen=True, eq=False)
class Products:
    """What the stages have given, None where the run did not get so far; curves in the order of the study.

    components: blade and damper, which the finite elements are put together from
    finer: the same curves with more harmonics, if they were asked for; point_errors: what finer samples
    and cycles change in them; stability: of the curves, as far as it is known; marched: their peaks, marched in time
    resonances: of the modes, followed in the force; detached: branches beside curves, where there are any
    failures: curves that are not there; unknown: what was to be said about curves, and could not
    left: jobs of which there is no file, since a quick look leaves them out
    named_modes: name -> frequency at forces so small that nothing slips or opens [Hz]
    """

    mesh: Stored[RigMesh]
    components: tuple[Stored[ComponentModel], ...] = ()
    finite_elements: Stored[FiniteElementResult] | None = None
    coupled_check: Stored[CoupledCheck] | None = None
    static_contact: Stored[StaticContact] | None = None
    curves: tuple[Stored[ResponseCurve], ...] = ()
    finer: tuple[Stored[ResponseCurve], ...] = ()
    point_errors: tuple[Stored[PointErrors], ...] = ()
    stability: tuple[Stored[BranchStability], ...] = ()
    marched: tuple[Stored[MarchedPeak], ...] = ()
    resonances: tuple[Stored[ResonanceCurve], ...] = ()
    detached: tuple[Stored[DetachedBranches], ...] = ()
    failures: tuple[JobOutcome, ...] = ()
    unknown: tuple[JobOutcome, ...] = ()
    left: tuple[Job, ...] = ()
    named_modes: Mapping[str, float] = field(default_factory=dict)

    def stability_of(self, mode: str) -> Mapping[float, BranchStability]:
        """By force, of the curves it is known of."""
        return {entry.product.force: entry.product for entry in self.stability if entry.product.mode == mode}

    def marched_of(self, mode: str) -> Mapping[float, MarchedPeak]:
        """By force, of the curves whose peaks were marched in time."""
        return {entry.product.force: entry.product for entry in self.marched if entry.product.mode == mode}

    def detached_of(self, mode: str) -> Mapping[float, DetachedBranches]:
        """By force, of the curves that have branches beside them."""
        return {entry.product.force: entry.product for entry in self.detached if entry.product.mode == mode}

    @property
    def stamps(self) -> tuple[store.Stamp, ...]:
        """Of all that is stored, whatever kind of product it is."""
        held = (getattr(self, one.name) for one in fields(self))
        entries = (entry for value in held for entry in (value if isinstance(value, tuple) else (value,)))
        return tuple(entry.stamp for entry in entries if isinstance(entry, Stored))


def why_stopped(product: object) -> str:
    """Of what is followed step by step, why it ended early; "" of all that did not."""
    return product.stopped if isinstance(product, ResponseCurve | ResonanceCurve) else ""


def stored(path: Path, kind: type[Product], key: str) -> Stored[Product] | None:
    """What the file holds if it was made with this key; a file that is missing or damaged counts as stale."""
    try:
        stamp = store.read_stamp(path)
        return Stored(path, store.read(path, kind), stamp) if stamp.key == key else None
    except store.StoreError:
        return None
