"""A parameter study's file, read and checked against its rig: every problem in one message."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Literal

from pydantic import Field, StringConstraints, ValidationError

from updamp.design.study_file import StudyError
from updamp.fem.contact_places import ContactPlace
from updamp.model.rig_files import load_any
from updamp.parameter_study.families import Family, MeasuredResonance, ParameterStudy, Variant
from updamp.parameter_study.family_pictures import PICTURES
from updamp.parameter_study.findings.finding import Finding
from updamp.parameter_study.findings.pesaresi2017 import PESARESI_2017
from updamp.rig.errors import RigError, explain
from updamp.rig.fields import InputTable
from updamp.rig.rig import Force, Frequency, Name, Rig
from updamp.rig.toml_file import read_toml

Label = Annotated[str, StringConstraints(pattern=r"^\S(.*\S)?$"), Field(examples=["50/50"])]
Place = Annotated[float, Field(strict=True, ge=-1, le=1, examples=[0.5])]

FINDINGS: Mapping[str, tuple[Finding, ...]] = MappingProxyType({"pesaresi2017": PESARESI_2017})  # sets that it can name


class StudyTable(InputTable):
    """[study]. rig, out: sought from the study file's folder; mesh: preset of the rig file; out gets a folder a mesh
    findings: set of findings to check, none where it is left out"""

    rig: Annotated[str, Field(examples=["../pesaresi2017.toml"])]
    mesh: str = "small"
    out: str
    jobs: Annotated[int, Field(strict=True, ge=1)] | None = None
    findings: str | None = None


class VariantTable(InputTable):
    """One [[variants]]. changes: values of the rig file by dotted path; none for the rig as it stands"""

    name: Label
    changes: Mapping[str, Any] = {}


class FamilyTable(InputTable):
    """One [[families]]. modes, forces: all of the rig file where they are left out"""

    name: Name
    title: str
    variants: Annotated[tuple[str, ...], Field(min_length=1, examples=[["50/50", "80/20"]])]
    modes: tuple[str, ...] = ()
    forces: tuple[Force, ...] = ()
    pictures: tuple[str, ...] = ("responses",)


class ContactTable(InputTable):
    """One place of [contacts]."""

    face: Literal["left", "right"]
    up: Place
    along: Place


class MeasuredTable(InputTable):
    """One [[measured]]."""

    mode: str
    force: Force
    resonance: Frequency


class StudyFile(InputTable):
    """All tables of the file."""

    study: StudyTable
    variants: Annotated[tuple[VariantTable, ...], Field(min_length=1)]
    families: Annotated[tuple[FamilyTable, ...], Field(min_length=1)]
    contacts: Mapping[Name, ContactTable] = {}
    measured: tuple[MeasuredTable, ...] = ()


def read_parameter_study(path: Path, mesh: str | None = None) -> ParameterStudy:
    """mesh: preset in the place of the file's own

    raises: StudyError with every problem found, one a line; RigError where its rig cannot be read
    """
    stated = read_toml(path, "a study file, such as rigs/studies/pesaresi2017.toml", StudyError, "parameter study")
    try:
        file = StudyFile.model_validate(stated)
    except ValidationError as error:
        raise _refused(path, list(explain(error, StudyFile))) from None
    rig_path = path.parent / file.study.rig
    rig = load_any(rig_path)
    if not isinstance(rig, Rig):
        raise _refused(
            path, [f"study.rig = {file.study.rig}: a rig given by modes has no faces; take one with geometry"]
        )
    preset = mesh or file.study.mesh
    if problems := list(_problems(file, rig, rig_path, preset)):
        raise _refused(path, problems)
    return ParameterStudy(
        path.stem, rig_path, preset, path.parent / file.study.out / preset, file.study.jobs, file.study.findings or "",
        tuple(Variant(one.name, dict(one.changes)) for one in file.variants),
        tuple(_family(one, rig) for one in file.families),
        tuple(ContactPlace(name, one.face, one.up, one.along) for name, one in file.contacts.items()),
        tuple(MeasuredResonance(one.mode, one.force, one.resonance) for one in file.measured),
    )  # fmt: skip


def _family(table: FamilyTable, rig: Rig) -> Family:
    modes, forces = table.modes or tuple(rig.study.modes), table.forces or rig.study.force_levels
    return Family(table.name, table.title, table.variants, modes, forces, table.pictures)


def _refused(path: Path, problems: Sequence[str]) -> StudyError:
    return StudyError("\n".join([f"{path}:", *problems]))


def _problems(file: StudyFile, rig: Rig, rig_path: Path, preset: str) -> Iterator[str]:
    if preset not in rig.mesh:
        yield f'study.mesh = "{preset}": the rig file has no such preset; it has {", ".join(rig.mesh)}'
    if file.study.findings and file.study.findings not in FINDINGS:
        yield f'study.findings = "{file.study.findings}": unknown; there are {", ".join(FINDINGS)}'
    names = [one.name for one in file.variants]
    yield from _twice("variants", names)
    yield from _twice("families", [one.name for one in file.families])
    for i, variant in enumerate(file.variants):
        yield from _of_variant(f"variants[{i}]", variant, rig_path)
    for i, family in enumerate(file.families):
        yield from _unknown(f"families[{i}].variants", family.variants, names)
        yield from _unknown(f"families[{i}].modes", family.modes, list(rig.study.modes))
        yield from _unknown(f"families[{i}].pictures", family.pictures, list(PICTURES))
    yield from _unknown("measured.mode", [one.mode for one in file.measured], list(rig.study.modes))


def _of_variant(place: str, variant: VariantTable, rig_path: Path) -> Iterator[str]:
    try:
        load_any(rig_path, variant.changes)
    except RigError as error:
        first, *others = str(error).splitlines()
        yield from (f'{place}, "{variant.name}": {line}' for line in others or [first])


def _twice(key: str, names: Sequence[str]) -> Iterator[str]:
    for name in dict.fromkeys(names):
        if names.count(name) > 1:
            yield f'{key}: name = "{name}" is there {names.count(name)} times; keep one'


def _unknown(key: str, named: Sequence[str], known: Sequence[str]) -> Iterator[str]:
    for name in named:
        if name not in known:
            yield f'{key}: "{name}" is unknown; there are {", ".join(known)}'
