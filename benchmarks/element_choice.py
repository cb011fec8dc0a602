"""20 or 27 nodes an element: first mode of the blade and cost of the factorisation, on the medium mesh.

.venv/bin/python benchmarks/element_choice.py [preset]
"""

from pathlib import Path
from time import perf_counter
from typing import Annotated

import numpy as np
import psutil
import skfem
import typer
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, eigsh
from skfem.helpers import dot
from skfem.io.meshio import INV_HEX_MAPPING
from skfem.models.elasticity import lame_parameters, linear_elasticity

from updamp.fem.solvers.pardiso import pardiso
from updamp.geometry.build_mesh import build_mesh
from updamp.geometry.rig_mesh import ComponentMesh
from updamp.model.rig_files import load_rig

RIG_FILE = Path(__file__).parent.parent / "rigs" / "pesaresi2017.toml"


@skfem.BilinearForm
def inertia(u, v, _):
    return dot(u, v)


def measure(blade: ComponentMesh, material, element: skfem.Element, order: int) -> tuple[int, float, float, float]:
    """Unknowns, first frequency [Hz], seconds and GB of the factorisation."""
    hexahedra = blade.hexahedra[:, INV_HEX_MAPPING[:8]].T.astype(np.int32)
    mesh = skfem.MeshHex(np.ascontiguousarray(blade.vertices.T), np.ascontiguousarray(hexahedra))
    basis = skfem.Basis(mesh, skfem.ElementVector(element), intorder=order)
    K = linear_elasticity(*lame_parameters(material.youngs_modulus, material.poissons_ratio)).assemble(basis)
    M = material.density * inertia.assemble(basis)
    free = np.flatnonzero(basis.doflocs[1] > 1e-9)
    K, M = (sparse.csr_array(matrix.tocsr()[free][:, free]) for matrix in (K, M))
    before, start = psutil.Process().memory_info().rss, perf_counter()
    factor = pardiso(sparse.bsr_array(K, blocksize=(3, 3)), np.zeros((len(free), 6)))
    seconds, memory = perf_counter() - start, psutil.Process().memory_info().rss - before
    inverse = LinearOperator(K.shape, matvec=factor.solve, dtype=np.float64)
    value = eigsh(K, 1, M, sigma=0, OPinv=inverse, v0=np.ones(len(free)), return_eigenvectors=False)[0]
    factor.close()
    return len(free), float(np.sqrt(value)) / (2 * np.pi), seconds, memory / 1e9


def main(preset: Annotated[str, typer.Argument(help="mesh of the rig file")] = "medium") -> None:
    """Measure and print both."""
    rig = load_rig(RIG_FILE)
    blade = build_mesh(rig, preset).blade
    print(
        f"{len(blade.hexahedra)} elements\n{'nodes':>5} {'unknowns':>9} {'first mode Hz':>14} {'factor s':>9} {'GB':>6}"
    )
    for nodes, element, order in ((20, skfem.ElementHexS2(), 4), (27, skfem.ElementHex2(), 4)):
        unknowns, frequency, seconds, memory = measure(blade, rig.material, element, order)
        print(f"{nodes:5} {unknowns:9} {frequency:14.4f} {seconds:9.1f} {memory:6.2f}", flush=True)


if __name__ == "__main__":
    typer.run(main)
