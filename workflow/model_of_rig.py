"""From a rig to its model in one call: stages taken from files where a folder is given, else computed in memory."""

from pathlib import Path

from rich.console import Console

from updamp.effects.rig_model import RigModel
from updamp.fem.finite_element_model import joined
from updamp.fem.reduced_model import ReducedModel
from updamp.fem.rig_components import RigComponents
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.model.build import modal_model, rig_model
from updamp.rig.modal_rig import ModalRig
from updamp.rig.rig import Rig
from updamp.workflow import stages
from updamp.workflow.limits import check_size
from updamp.workflow.progress import Display
from updamp.workflow.run import Run
from updamp.workflow.run_options import RunOptions
from updamp.workflow.stage_functions import StageFunctions


def model_of_rig(
    rig: Rig | ModalRig, preset: str, folder: Path | None = None, functions: StageFunctions | None = None
) -> RigModel:
    """The model with the calibration and the effects of the rig's file.

    preset: of the mesh; without meaning for a rig given by modes
    folder: of a run: what is there and still holds is taken from its files, what is missing is computed and stored
    functions: what each stage calls
    raises: ValueError naming a preset, an effect or a factor that the rig has no place for; what the stages raise
    """
    if isinstance(rig, ModalRig):
        return modal_model(rig)
    if preset not in rig.mesh:
        raise ValueError(f'mesh = "{preset}": the rig file has no such preset; it has {", ".join(rig.mesh)}')
    functions = functions or StageFunctions()
    reduced, rest = _stored(rig, preset, folder, functions) if folder else _computed(rig, preset, functions)
    return rig_model(reduced, rest, rig)


def _computed(rig: Rig, preset: str, functions: StageFunctions) -> tuple[ReducedModel, StaticContact]:
    check_size(rig, preset)
    mesh = functions.mesh(rig, preset)
    with RigComponents(mesh, rig) as parts:
        reduced = joined(functions.blade(parts), functions.damper(parts), mesh.contacts).reduced
    return reduced, functions.static_contact(rig, reduced)


def _stored(rig: Rig, preset: str, folder: Path, functions: StageFunctions) -> tuple[ReducedModel, StaticContact]:
    options = RunOptions(preset, folder, check=False, until=stages.STATIC_CONTACT)
    with Display(Console(quiet=True)) as display:
        done = Run(rig, options, display, functions).products()
    assert done.finite_elements is not None, "the run goes as far as static contact"
    assert done.static_contact is not None, "the run goes as far as static contact"
    return done.finite_elements.product.reduced, done.static_contact.product
