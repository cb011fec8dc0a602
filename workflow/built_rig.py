"""A rig built as far as static contact, for comparisons: on its mesh, on finer ones, and once more for each dimension
that may be other than its file says (`effects/dimension_blend.py`)."""

import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from updamp.effects.contact_faces import laid_out_alike
from updamp.effects.dimension_blend import on_finer_mesh, varied_dimension
from updamp.effects.mode_alignment import ModesDifferError
from updamp.effects.rig_model import RigModel
from updamp.effects.varied_dimension import VariedDimension
from updamp.effects.wrong_dimension import TYPICAL
from updamp.geometry.contact_triangulation import contact_elements
from updamp.model.build import as_built
from updamp.model.calibration import calibrated
from updamp.rig.checks import buildable
from updamp.rig.dimensions import DIMENSIONS
from updamp.rig.rig import Rig
from updamp.rig.size import finer_presets
from updamp.workflow import stages, store
from updamp.workflow.progress import Display
from updamp.workflow.run import Run
from updamp.workflow.run_options import RunOptions

NO_FINER = "no finer preset: what a finer mesh and more contact elements would change counts as misfit"
FOLDER = "dimensions"
# The first that can be built with the same contact elements, and short enough for modes to be told, is taken.
STEPS = tuple(sign * TYPICAL / part for part in (1, 2, 4, 8) for sign in (1, -1))


def chosen_dimensions(names: Sequence[str] | None) -> tuple[str, ...]:
    """None for all of them; raises: ValueError naming one that there is not"""
    for name in names or ():
        if name not in DIMENSIONS:
            raise ValueError(f"--dimensions {name}: there are {', '.join(DIMENSIONS)}; or none")
    return tuple(DIMENSIONS) if names is None else tuple(dict.fromkeys(names))


@dataclass(frozen=True, eq=False)
class BuiltRig:
    """A rig on one mesh, as far as static contact. run: of its stages"""

    run: Run

    @cached_property
    def model(self) -> RigModel:
        """Before calibration and effects."""
        done = self.run.products()
        assert done.finite_elements is not None, "the run goes as far as static contact"
        assert done.static_contact is not None, "the run goes as far as static contact"
        return as_built(done.finite_elements.product.reduced, done.static_contact.product, self.run.rig)

    def before_effects(self, dimensions: Mapping[str, VariedDimension]) -> RigModel:
        """With the calibration of the rig file, and what these dimensions change."""
        return calibrated(replace(self.model, dimensions=dict(dimensions)), self.run.rig.calibration)

    def varied(self, names: Sequence[str]) -> dict[str, VariedDimension]:
        """Built, in folders of their own; those that no step can be built of are left out, and said."""
        found = {}
        for name in names:
            try:
                found[name] = next(self._steps(name))
            except StopIteration:
                self.run.display.note("check", f"{name}: no step of {DIMENSIONS[name].key} can be built and compared")
        return found

    def varied_as(self, coarse: "BuiltRig", dimensions: Mapping[str, VariedDimension]) -> dict[str, VariedDimension]:
        """Those of a coarser mesh, for this one: built again only where contact elements or modes are not the same."""
        patches, others = self.model.patches, coarse.model.patches
        assert patches is not None, "of a rig with contacts"
        assert others is not None, "of a rig with contacts"
        if laid_out_alike(patches, others):
            try:
                return {name: on_finer_mesh(varied, self.model) for name, varied in dimensions.items()}
            except ModesDifferError:
                pass
        return self.varied(tuple(dimensions))

    def _steps(self, name: str) -> Iterator[VariedDimension]:
        """Of each step that does."""
        for step in STEPS:
            rig = DIMENSIONS[name].changed(self.run.rig, step)
            if self._can_be_compared(rig):
                try:
                    yield varied_dimension(self.model, BuiltRig(self._beside(rig, f"{name}{step:+g}")).model, step)
                except ModesDifferError:
                    continue

    def _can_be_compared(self, rig: Rig) -> bool:
        preset = self.run.options.preset
        return not buildable(rig) and laid_out_alike(
            *(contact_elements(each, each.mesh[preset]) for each in (rig, self.run.rig))
        )

    def _beside(self, rig: Rig, name: str) -> Run:
        """In a folder of this name, with the component that the dimension leaves alone."""
        options = replace(self.run.options, folder=self.run.options.folder / FOLDER / name)
        beside = Run(rig, options, self.run.display, self.run.functions)
        for stage in (stages.BLADE, stages.DAMPER):
            source, target = (run.files.file(stage.name) for run in (self.run, beside))
            if self.run.files.key(stage) == beside.files.key(stage) == store.read_stamp(source).key:
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(source, target)
        return beside


def built_rig(rig: Rig, preset: str, folder: Path, workers: int, display: Display) -> BuiltRig:
    """raises: as `Run`"""
    return BuiltRig(Run(rig, RunOptions(preset, folder, workers, check=False, until=stages.STATIC_CONTACT), display))


def finer_rigs(
    rig: Rig, preset: str, out: Path, workers: int, display: Display, finer: Sequence[str] | None
) -> dict[str, BuiltRig]:
    """By preset, in folders of their own; raises: ValueError where memory does not hold one"""
    if not (names := finer_presets(rig, preset) if finer is None else tuple(dict.fromkeys(finer))):
        display.note("check", NO_FINER)
    try:
        return {name: built_rig(rig, name, out / name, workers, display) for name in names}
    except ValueError as error:
        if finer is not None:
            raise
        raise ValueError(f"{error}\nor, without what tells the numerical error: --finer none") from None
