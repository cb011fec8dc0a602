"""Stuck frequencies of the reference rig against the mesh: contact patches converge, single nodes do not.

The same 146 contact elements on every mesh; full finite element models, no reduction.

    .venv/bin/python benchmarks/contact_coupling_convergence.py [small medium ...]
"""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from updamp.fem.component import Component, FactorisedComponent, factorised
from updamp.fem.coupled_modes import coupled_modes_full, static_flexibility
from updamp.fem.coupling import COUPLINGS, Coupling
from updamp.fem.interface import blade_interface, damper_interface
from updamp.fem.rig_components import assemble_rig
from updamp.fem.solvers import solver_named
from updamp.fem.springs import ContactStiffness, Springs, on_damper, stuck_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.geometry.contact_elements import ContactElements
from updamp.geometry.rig_mesh import RigMesh
from updamp.model.rig_files import load_rig
from updamp.rig.mesh_divisions import MeshDivisions
from updamp.rig.rig import Rig
from updamp.rig.wires import wire_springs

RIG_FILE = Path(__file__).parent.parent / "rigs" / "pesaresi2017.toml"


def rig_springs(rig: Rig, mesh: RigMesh) -> Springs:
    stiffness = ContactStiffness(rig.contact.tangential_stiffness, rig.contact.normal_stiffness)
    return stuck_contact(mesh.contacts, stiffness) + on_damper(mesh.contacts, wire_springs(rig))


def coupled_by(part, contacts: ContactElements, coupling: Coupling, interface_of) -> FactorisedComponent:
    """The same factorisation behind another interface."""
    own: Component = part.component
    interface = interface_of(own.mesh, own.matrices, contacts, coupling)
    return FactorisedComponent(replace(own, interface=interface), part.factors)


def stuck_frequencies(rig: Rig, divisions: dict[str, int]) -> tuple[int, dict[str, np.ndarray]]:
    """Elements of both blades; coupling -> (OOP, IP) [Hz]"""
    rig = rig.model_copy(update={"mesh": {"here": MeshDivisions(**divisions)}})
    mesh = build_mesh(rig, "here")
    solver = solver_named(rig.reduction.solver)
    found = {}
    blade_part, damper_part = assemble_rig(mesh, rig, COUPLINGS["patch"])
    with factorised(blade_part, solver) as on_root, factorised(damper_part, solver) as on_support:
        for name, coupling in COUPLINGS.items():
            blade = coupled_by(on_root, mesh.contacts, coupling, blade_interface)
            damper = coupled_by(on_support, mesh.contacts, coupling, damper_interface)
            modes = coupled_modes_full(blade, damper, static_flexibility(blade), rig_springs(rig, mesh))
            found[name] = modes.frequencies[[modes.out_of_phase, modes.in_phase]]
    return mesh.blade_elements, found


def meshes(rig: Rig) -> dict[str, dict[str, int]]:
    """The presets, and between them the medium one with the contact faces alone twice as fine."""
    contacts = {"contact_elements": rig.mesh["full"].contact_elements}
    presets = {name: rig.mesh[name].model_dump() | contacts for name in ("small", "medium", "full")}
    medium = presets["medium"]
    finer = {key: 2 * medium[key] for key in ("width", "face", "damper_across")}
    return {
        "small": presets["small"],
        "medium": medium,
        "medium, contact faces x 2": medium | finer,
        "full": presets["full"],
    }


def main(chosen: Annotated[list[str] | None, typer.Argument(help="meshes; all where none is named")] = None) -> None:
    """Solve and print."""
    rig = load_rig(RIG_FILE)
    print(f"{'mesh':26} {'elements':>8} {'coupling':12} {'OOP Hz':>8} {'IP Hz':>8}   change from medium (OOP, IP) %")
    medium: dict[str, np.ndarray] = {}
    for mesh, divisions in meshes(rig).items():
        if chosen and mesh not in chosen:
            continue
        elements, found = stuck_frequencies(rig, divisions)
        medium = found if mesh == "medium" else medium
        for name, (oop, ip) in found.items():
            change = " ".join(
                f"{100 * (f / m - 1):7.3f}" for f, m in zip((oop, ip), medium.get(name, ()), strict=False)
            )
            print(f"{mesh:26} {elements:8} {name:12} {oop:8.3f} {ip:8.3f}   {change}", flush=True)


if __name__ == "__main__":
    typer.run(main)
