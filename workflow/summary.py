"""What a run found, in numbers: summary.json, written and read back."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.fem.finite_element_model import CoupledCheck, FiniteElementResult
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.geometry.rig_mesh import RigMesh
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.continuation.sweeps import swept
from updamp.hbm.resonance.quadrature import quadrature_resonances
from updamp.hbm.resonance.resonance_curve import ResonanceCurve
from updamp.hbm.stability.branch_stability import BranchStability
from updamp.hbm.stability.detached_branches import DetachedBranches
from updamp.hbm.time_marching.marched_peak import MarchedPeak
from updamp.parallel.whole_file import write_whole
from updamp.workflow.adaptive_curves import ChosenHarmonics
from updamp.workflow.detached_summary import detached_entries
from updamp.workflow.followed_summary import followed_entry
from updamp.workflow.marching_summary import marching_entry
from updamp.workflow.output_folder import SUMMARY
from updamp.workflow.stability_summary import stability_entry

CURVE_KEYS = ("mode", "force_N", "points", "seconds", "problem")  # that every curve's entry has


def mesh_entry(mesh: RigMesh) -> dict[str, Any]:
    return {
        "blade_elements": mesh.blade_elements,
        "damper_elements": mesh.damper_elements,
        "contact_elements": len(mesh.contacts),
        "min_scaled_jacobian": mesh.min_scaled_jacobian,
    }


def modes_entry(result: FiniteElementResult) -> dict[str, Any]:
    return {
        "per_component": len(result.blade_frequencies),
        "free_1F_Hz": float(result.blade_frequencies[0]),
        "max_relative_residual": result.reduced.max_relative_residual,
    }


def coupled_entry(check: CoupledCheck) -> dict[str, Any]:
    def of(mode: int) -> dict[str, float]:
        return {"full": float(check.full[mode]), "reduced": float(check.reduced[mode])}

    return {
        "OOP_Hz": of(check.out_of_phase),
        "IP_Hz": of(check.in_phase),
        "first_modes_Hz": {"full": check.full.tolist(), "reduced": check.reduced.tolist()},
        "largest_difference": check.largest_difference,
        "max_relative_residual": check.max_relative_residual,
    }


def static_entry(rest: StaticContact) -> dict[str, Any]:
    return {
        "applied_N": rest.applied,
        "normal_total_N": rest.normal_total,
        "equilibrium_error": rest.equilibrium_error,
        "pressure_model": rest.model,
    }


def curve_entry(
    curve: ResponseCurve,
    point: str,
    numerical_error: Mapping[str, Any] | None = None,
    stability: BranchStability | None = None,
    chosen: ChosenHarmonics | None = None,
    detached: DetachedBranches | None = None,
    marched: MarchedPeak | None = None,
    followed: ResonanceCurve | None = None,
) -> dict[str, Any]:
    """point: where the peak is taken, first harmonic; a branch that found no point at all has no peak

    numerical_error: where the run says how accurate it is; chosen: where the harmonics were chosen for this curve
    detached: where branches were found that are no part of it; marched: where the peak was marched in time
    followed: the mode's resonance, where it was followed in the force
    """
    entry: dict[str, Any] = {
        "mode": curve.mode,
        "force_N": curve.force,
        "peak_receptance_mm_per_N": None,
        "peak_frequency_Hz": None,
        "points": len(curve),
        "unconverged": curve.unconverged,
        "seconds": round(curve.seconds, 2),
        "response_point": point,
        "complete": curve.complete,
        "problem": problem(curve),
        "harmonics": list(curve.orders),
        "harmonics_chosen": {"highest_tried": list(chosen.tried), "status": chosen.status} if chosen else None,
        "numerical_error": numerical_error,
        "stability": stability_entry(curve, stability, point) if stability is not None else None,
        "marching": marching_entry(marched) if marched is not None else None,
        "detached": detached_entries(detached, point),
        "followed": followed_entry(curve, followed, point, numerical_error),
    }
    if len(curve):
        entry |= _solved(curve, point)
    return entry


def _solved(curve: ResponseCurve, point: str) -> dict[str, Any]:
    frequency, peak = curve.peak(point)
    at_peak = int(np.abs(curve.receptance(point)).argmax())
    return {
        "peak_receptance_mm_per_N": 1e3 * peak,
        "peak_frequency_Hz": frequency,
        "resonances": [
            {"frequency_Hz": r.frequency, "receptance_mm_per_N": 1e3 * r.receptance}
            for r in quadrature_resonances(curve, point)
        ],
        "gaps_Hz": curve.gaps().tolist(),
        "largest_residual": float(curve.error.max()),
        "energy_balance_error": energy_balance_error(curve),
        "friction_share_of_loss_at_peak": _largest_share(curve.friction_loss[[at_peak]], curve.work_in[[at_peak]]),
        "jumps_up_Hz": jumps(curve, upwards=True),
        "jumps_down_Hz": jumps(curve, upwards=False),
    }


def resonance_entry(curve: ResonanceCurve, levels: Sequence[float]) -> dict[str, Any]:
    """Of a resonance followed in the force, at the levels [N] that it reached: each where it was first met."""
    met = [int(places[0]) for level in sorted(levels) if len(places := curve.passes(level))]
    return {
        "mode": curve.mode,
        "response_point": curve.point,
        "complete": curve.complete,
        "stopped": curve.stopped,
        "seconds": round(curve.seconds, 2),
        "points": len(curve),
        "at_levels": {
            "force_N": curve.force[met].tolist(),
            "frequency_Hz": curve.frequency[met].tolist(),
            "receptance_mm_per_N": (1e3 * np.abs(curve.receptance[met])).tolist(),
            "loss_factor": curve.loss_factor[met].tolist(),
        }
        if met
        else {},
    }


def problem(curve: ResponseCurve) -> str:
    """Why the curve is not the whole branch through its window; "" where it is (hbm/continuation/completeness.py)."""
    return curve.stopped or ("" if len(curve) else "the branch has no point")


def energy_balance_error(curve: ResponseCurve) -> float | None:
    """Largest |work of the excitation - friction loss - material loss| over that work, of all points."""
    return _largest_share(np.abs(curve.work_in - curve.friction_loss - curve.material_loss), np.abs(curve.work_in))


def _largest_share(part: NDArray[np.float64], work: NDArray[np.float64]) -> float | None:
    """None where a point takes no work, as without any damping: there is nothing that it could be a share of."""
    sound = np.isfinite(part).all() and np.isfinite(work).all() and work.all()
    return float((part / work).max()) if sound else None


def jumps(curve: ResponseCurve, upwards: bool) -> list[float]:
    """Frequencies at which a slow sweep jumps [Hz]; none are known of a branch that was not followed throughout."""
    return swept(curve, upwards).jumps.tolist() if curve.complete else []


def union_length(intervals: Sequence[tuple[float, float]]) -> float:
    """Time covered by at least one of the intervals: the wall time of work done in parallel."""
    total, reached = 0.0, -np.inf
    for start, end in sorted(intervals):
        total += max(end - max(start, reached), 0.0)
        reached = max(reached, end)
    return float(total)


def write_summary(path: Path, summary: Mapping[str, Any]) -> None:
    write_whole(path, (json.dumps(summary, indent=2) + "\n").encode())


def read_summary(folder: Path) -> Mapping[str, Any]:
    """What a run left there. raises: ValueError naming the file, what is wrong with it and the command that makes it"""
    path = folder / SUMMARY
    remedy = f"make it with: updamp run RIG --mesh PRESET --out {folder}"
    if not path.is_file():
        raise ValueError(f"{path}: no such file; {remedy}")
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"{path}: cannot be read: {error.strerror}; mend that, or {remedy}") from None
    except ValueError as error:  # no JSON, or no text
        raise ValueError(f"{path}: damaged ({error}); {remedy}") from None
    if not _sound(content):
        raise ValueError(f"{path}: not what a run writes; {remedy}")
    return dict(content)


def _sound(content: Any) -> bool:
    if not isinstance(content, dict) or not isinstance(content.get("rig"), str):
        return False
    curves = content.get("curves", [])
    return isinstance(curves, list) and all(isinstance(c, dict) and set(c) >= set(CURVE_KEYS) for c in curves)
