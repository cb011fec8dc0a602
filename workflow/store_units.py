"""Unit of every stored number, by class and field; "1" where there is none. Text needs no entry.

Classes are named, not imported, so that reading a file does not load the stage that wrote it.
"""

from collections.abc import Mapping

UNITS: Mapping[str, Mapping[str, str]] = {
    "ContactElements": {
        "face": "1",
        "centroid": "m",
        "area": "m^2",
        "tangent1": "1",
        "tangent2": "1",
        "normal": "1",
        "triangle": "m",
    },
    "ComponentMesh": {"vertices": "m", "hexahedra": "1", "faces": "1", "points": "1"},
    "RigMesh": {"min_scaled_jacobian": "1"},
    "ReducedComponent": {"omega": "rad/s", "phi": "kg^-1/2", "residual": "m/N"},
    "ReducedModel": {"max_relative_residual": "1"},
    "FiniteElementResult": {
        "blade_frequencies": "Hz",
        "damper_frequencies": "Hz",
        "blade_shapes": "kg^-1/2",
        "seconds": "s",
    },
    "CoupledCheck": {
        "full": "Hz",
        "reduced": "Hz",
        "out_of_phase": "1",
        "in_phase": "1",
        "shapes": "kg^-1/2",
        "max_relative_residual": "1",
    },
    "StaticContact": {
        "normal_force": "N",
        "tangential_force": "N",
        "gap": "m",
        "applied": "N",
        "normal_total": "N",
        "equilibrium_error": "1",
    },
    "ResponseCurve": {
        "force": "N",
        "orders": "1",
        "frequency": "Hz",
        "displacement": "m",
        "response": "m",
        "work_in": "J",
        "friction_loss": "J",
        "material_loss": "J",
        "iterations": "1",
        "error": "1",
        "active": "1",
        "complete": "1",
        "seconds": "s",
        "after_gap": "1",
    },
    "BranchStability": {
        "force": "N",
        "state": "1",
        "computed": "1",
        "growth": "1/s",
        "why": "1",
        "seconds": "s",
    },
    "PointErrors": {
        "force": "N",
        "samples": "%, Hz, %",
        "cycles": "%, Hz, %",
    },
    "ChosenHarmonics": {"force": "N", "orders": "1", "tried": "1"},
}
