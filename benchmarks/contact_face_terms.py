"""Would few terms of a face's displacement do, with the contact law at many points of it?

    .venv/bin/python benchmarks/contact_face_terms.py
    .venv/bin/python benchmarks/contact_face_terms.py --points 72/4 --points 288/8 --degree 3 --effect edge_gap:2e-7

A contact element has one displacement and one state, so that unknowns and points of the law are one number: many are
needed where faces open from an edge or the pressure falls. Here a face's displacement is a polynomial of its two
coordinates, orthonormal over its area, and the law is evaluated at the points of as many contact elements as are asked
for; forces are projected onto the same terms, so that the work is theirs. Printed: peaks, with elements (degree 0) and
with terms. A trial of a formulation: the law is evaluated at all points, whether they stick or not.
"""

import os

from updamp.parallel.resources import thread_limits

os.environ.update(thread_limits(1))

import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import typer
from numpy.polynomial.legendre import legvander2d
from numpy.typing import NDArray
from rich.console import Console

from updamp.benchmarks.contact_mesh_convergence import divided
from updamp.effects.catalogue import CATALOGUE
from updamp.effects.contact_faces import along_damper, patches_of, up_the_face
from updamp.effects.rig_model import RigModel
from updamp.geometry.contact_elements import LEFT, RIGHT
from updamp.hbm.compilation_cache import keep_compiled
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.law import CompiledForces
from updamp.hbm.continuation.curve import CurveRequest, whole_curve
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.system import Excitation, NonlinearSystem
from updamp.model.rig_files import load_rig

Floats = NDArray[np.float64]
RIG = Path(__file__).parents[1] / "rigs" / "virtual_rig.toml"
BOX = JenkinsBox()


class FaceParameters(NamedTuple):
    """Those of the friction law, (n_faces, n_points, ...). terms: (n_faces, n_points, n_terms) values at the points"""

    mu: Any
    kt: Any
    kn: Any
    n0: Any
    t0: Any
    gap: Any
    terms: Any

    def at_points(self) -> FrictionParameters:
        return FrictionParameters(*self[:-1])


@dataclass(frozen=True)
class FaceLaw:
    """A face as one element: its displacements are the sizes of the terms, (t1, t2, n) of each."""

    n_terms: int
    parameters: ClassVar[type] = FaceParameters
    rate_dependent: ClassVar[bool] = False
    cycles: ClassVar[int] = 2

    @property
    def directions(self) -> int:
        return 3 * self.n_terms

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: FaceParameters) -> jax.Array:
        def at_points(of_face: jax.Array) -> jax.Array:
            of_terms = of_face.reshape(len(of_face), self.n_terms, 3)
            return jnp.einsum("qb,tbd->qtd", parameters.terms, of_terms)

        forces = jax.vmap(BOX.force)(at_points(displacement), at_points(velocity), parameters.at_points())
        return jnp.einsum("qb,qtd->tbd", parameters.terms, forces).reshape(displacement.shape)

    def reference_stiffness(self, parameters: FaceParameters) -> jax.Array:
        springs = jnp.stack([parameters.kt, parameters.kt, parameters.kn], axis=-1)
        return jnp.einsum("qb,qd->bd", parameters.terms**2, springs).ravel()

    def compiled(self, harmonics: Harmonics, n_time: int) -> CompiledForces:
        return FaceForces(BOX.compiled(harmonics, n_time), self.n_terms)


@dataclass(frozen=True, eq=False)
class FaceForces:
    """As `law.CompiledForces`. inside: of the law at a point"""

    inside: CompiledForces
    n_terms: int

    def write_forces(self, numbers: Any, displacement: Floats, w: Any, parameters: Any, force: Floats) -> None:
        tangent = np.zeros((*displacement.shape, *displacement.shape[1:]))
        self.write_with_tangents(numbers, displacement, w, parameters, force, tangent, np.zeros_like(force))

    def write_with_tangents(
        self,
        numbers: Any,
        displacement: Floats,
        w: Any,
        parameters: FaceParameters,
        force: Floats,
        tangent: Floats,
        by_frequency: Floats,  # noqa: ARG002 - none: the law does not depend on the rate
    ) -> None:
        c, n = displacement.shape[2], self.n_terms
        for face in numbers:
            terms, own = parameters.terms[face], (np.ascontiguousarray(v[face]) for v in parameters.at_points())
            at = np.einsum("qb,bdc->qdc", terms, displacement[face].reshape(n, 3, c))
            forces, tangents = np.zeros_like(at), np.zeros((len(at), 3, c, 3, c))
            every = np.arange(len(at))
            self.inside.write_with_tangents(every, at, w, FrictionParameters(*own), forces, tangents, np.zeros_like(at))
            force[face] = np.einsum("qb,qdc->bdc", terms, forces).reshape(3 * n, c)
            pairs = np.einsum("qb,qa->baq", terms, terms).reshape(n * n, -1)
            summed = (pairs @ tangents.reshape(len(at), -1)).reshape(n, n, 3, c, 3, c)
            tangent[face] = summed.transpose(0, 2, 3, 1, 4, 5).reshape(3 * n, c, 3 * n, c)


def orthonormal(s: Floats, t: Floats, area: Floats, degree: int) -> Floats:
    """(n_points, n_terms) of polynomials up to a degree, whose mean square over the area is 1"""
    orders = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    values = legvander2d(s, t, [degree, degree]).reshape(len(s), degree + 1, degree + 1)
    raw = np.stack([values[:, i, j] for i, j in orders], axis=1)
    root = np.sqrt(area / area.sum())[:, None]
    return np.asarray(np.linalg.qr(root * raw)[0] / root)


def on_terms(model: RigModel, degree: int) -> NonlinearSystem:
    """The model's problem with the displacement of each face in polynomials, and the law at its contact elements."""
    assert model.contacts is not None
    patches, own, free = patches_of(model), model.contacts.parameters, model.free
    s, t, area, n = along_damper(patches), up_the_face(patches), patches.area, len(patches)
    faces = [np.flatnonzero(patches.face == side) for side in (LEFT, RIGHT)]
    terms = [orthonormal(s[on], t[on], area[on], degree) for on in faces]
    m = terms[0].shape[1]
    shapes = np.zeros((n, 2 * m))
    for i, (on, of_face) in enumerate(zip(faces, terms, strict=True)):
        shapes[on, i * m : (i + 1) * m] = of_face
    weighted = np.repeat(area, 3)[:, None] * np.kron(shapes, np.eye(3))
    onto = weighted / np.concatenate([np.full(3 * m, area[on].sum()) for on in faces])
    others = free.n_rows - 3 * n
    rows = np.block([[onto, np.zeros((3 * n, others))], [np.zeros((others, 6 * m)), np.eye(others)]])
    few = replace(free, phi=rows.T @ free.phi, residual=rows.T @ free.residual @ rows, n_relative=6 * m)
    each = (np.stack([np.asarray(value)[on] for on in faces]) for value in own)
    group = ElementGroup(FaceLaw(m), FaceParameters(*each, np.stack(terms)), np.arange(6 * m).reshape(2, -1))
    return NonlinearSystem(few, (group,), model.harmonics, model.time_samples, as_a_whole=True, mean_held=True)


def main(
    mesh: Annotated[str, typer.Option(help="preset of the rig file for the finite elements")] = "diagnosis",
    points: Annotated[list[str] | None, typer.Option(help="of both faces, 72/4: in four strips")] = None,
    degree: Annotated[list[int] | None, typer.Option(help="of the polynomials; 0: contact elements")] = None,
    curve: Annotated[list[str] | None, typer.Option(help="mode:force in N")] = None,
    effect: Annotated[str, typer.Option(help="of one parameter, such as pressure_crown:1.3")] = "",
) -> None:
    """Peaks of the virtual rig, with contact elements and with terms."""
    keep_compiled()
    console, rig = Console(width=140), load_rig(RIG)
    name, _, value = effect.partition(":")
    for count in points or ["72/4", "182/7", "288/8"]:
        model = divided(rig, mesh, count)
        if effect:
            (parameter,) = CATALOGUE[name].parameters
            model = CATALOGUE[name].apply(model, {parameter.name: float(value)})
        for k in degree or [0, 3, 4]:
            system = on_terms(model, k) if k else model.system
            for text in curve or ["IP:8", "OOP:32"]:
                mode, _, force = text.partition(":")
                driven = Excitation(system.free.row(model.excitation), float(force))
                started = time.process_time()
                found = whole_curve(
                    system, CurveRequest(mode, driven, rig.study.modes[mode].window, (rig.response_point,))
                )
                at, height = found.peak(rig.response_point)
                unknowns = system.free.n_relative * system.harmonics.n_coefficients
                console.print(
                    f"{count} points, {f'degree {k}' if k else 'elements'}, {unknowns} unknowns, {mode} {force} N: "
                    f"{at:.4f} Hz, {1e3 * height:.6f} mm/N, {time.process_time() - started:.1f} s",
                    soft_wrap=True,
                )


if __name__ == "__main__":
    typer.run(main)
