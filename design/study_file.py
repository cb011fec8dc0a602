"""A study file, read and checked against its rig: every problem in one message.

Its words are those of Dakota and HyperStudy: variables, responses, objectives, constraints, method.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import Field, ValidationError

from updamp.design.goals import Constraint, ConstraintTable, Objective, ObjectiveTable, constraint, objective
from updamp.design.methods import (  # noqa: F401  # importing the files registers them; a new one joins with its name
    full_grid,
    gaussian_process,
    latin_hypercube,
    least_squares,
    morris,
    nsga2,
    one_at_a_time,
    posterior,
    sobol,
    sobol_indices,
    tpe,
)
from updamp.design.methods.method import METHODS, Method
from updamp.design.responses import contacts, energies, frequencies, jumps, masses, peaks  # noqa: F401  # likewise
from updamp.design.responses.response import RESPONSES, Response
from updamp.design.rig_numbers import AnyRig
from updamp.design.variables import Variable, VariableTable, variable
from updamp.model.rig_files import load_any
from updamp.rig.errors import RigError, explain
from updamp.rig.fields import InputTable
from updamp.rig.modal_rig import ModalRig
from updamp.rig.toml_file import read_toml

Table = TypeVar("Table", bound=InputTable)
T = TypeVar("T")

OTHER_COLUMNS = ("number", "outcome", "feasible", "seconds", "executed", "routes", "reason")  # of a study's table
_KEYS = ("study", "variables", "responses", "objectives", "constraints", "method")


class StudyError(ValueError):
    """A study file that cannot be used; the message has one line a problem."""


class StudyTable(InputTable):
    """[study]. rig, out: sought from the study file's folder; mesh: preset of the rig file
    jobs: designs that are solved at the same time
    most_points: of one resonance followed in the force, and of one whole curve; what takes more is not known. Points
        of a curve are those of all its pieces
    """

    rig: Annotated[str, Field(examples=["../pesaresi2017.toml"])]
    mesh: str = "small"
    out: str | None = None
    jobs: Annotated[int, Field(strict=True, ge=1)] | None = None
    most_points: Annotated[int, Field(strict=True, ge=10)] | None = None


@dataclass(frozen=True)
class DesignStudy:
    """rig: file; out: folder; jobs, most_points: None where the file does not say; the rest as in the file, resolved"""

    name: str
    rig: Path
    mesh: str
    out: Path | None
    jobs: int | None
    variables: tuple[Variable, ...]
    responses: tuple[Response, ...]
    objectives: tuple[Objective, ...]
    constraints: tuple[Constraint, ...]
    method: Method
    method_name: str
    most_points: int | None


def read_study(path: Path) -> DesignStudy:
    """raises: StudyError with every problem found, one a line; RigError where its rig cannot be read"""
    stated = read_toml(path, "a study file, such as rigs/studies/friction.toml", StudyError, "design study")
    problems: list[str] = []
    head = _section(stated, "study", StudyTable, problems)
    problems += [f"{key}: unknown key; {_instead(key, _KEYS)}" for key in stated if key not in _KEYS]
    if (rig_name := _stated_rig(stated)) is None:
        raise _refused(path, problems)
    rig_path = path.parent / rig_name
    try:
        rig = load_any(rig_path)
    except RigError as error:
        raise _refused(path, [*problems, *(f"study.rig: {line}" for line in str(error).splitlines())]) from None
    problems += _mesh(rig, head.mesh) if head is not None else ()
    variables = _variables(stated, rig, problems)
    responses = _responses(stated, rig, problems)
    units = {one.name: one.unit for one in responses}
    problems += _columns([*(one.name for one in variables), *units])
    objectives = _each(stated, "objectives", ObjectiveTable, lambda t: objective(t, units), problems, needed=False)
    constraints = _each(stated, "constraints", ConstraintTable, lambda t: constraint(t, units), problems, needed=False)
    method, method_name = _method(stated, problems)
    if method is not None and not problems and (why := method.problem(variables, objectives)):
        problems.append(f'method.kind = "{method_name}": {why}')
    if problems or method is None or head is None:
        raise _refused(path, problems)
    out = path.parent / head.out if head.out else None
    return DesignStudy(
        path.stem, rig_path, head.mesh, out, head.jobs, variables, responses, objectives, constraints, method,
        method_name, head.most_points,
    )  # fmt: skip


def _stated_rig(stated: Mapping[str, Any]) -> str | None:
    """Whatever else is wrong with the table: so that the rest of the file can be checked against the rig"""
    rig = stated["study"].get("rig") if isinstance(stated.get("study"), Mapping) else None
    return rig if isinstance(rig, str) else None


def _refused(path: Path, problems: Sequence[str]) -> StudyError:
    return StudyError("\n".join([f"{path}:", *problems]))


def _section(stated: Mapping[str, Any], key: str, kind: type[Table], problems: list[str]) -> Table | None:
    if not isinstance(stated.get(key), Mapping):
        problems.append(f"{key}: missing; add the table [{key}] with {', '.join(kind.model_fields)}")
        return None
    return _validated(stated[key], key, kind, problems)


def _validated(table: Mapping[str, Any], place: str, kind: type[Table], problems: list[str]) -> Table | None:
    try:
        return kind.model_validate(table)
    except ValidationError as error:
        problems += [f"{place}.{line}" for line in explain(error, kind)]
        return None


def _mesh(rig: AnyRig, mesh: str) -> Iterator[str]:
    if not isinstance(rig, ModalRig) and mesh not in rig.mesh:
        yield f'study.mesh = "{mesh}": the rig file has no such preset; it has {", ".join(rig.mesh)}'


def _tables(stated: Mapping[str, Any], key: str, problems: list[str], needed: bool) -> list[Mapping[str, Any]]:
    tables = stated.get(key, [])
    if not isinstance(tables, list) or not all(isinstance(table, Mapping) for table in tables):
        problems.append(f"{key}: tables are wanted, [[{key}]]")
        return []
    if needed and not tables:
        problems.append(f"{key}: none is stated; add one or more tables [[{key}]]")
    return tables


def _each(
    stated: Mapping[str, Any],
    key: str,
    kind: type[Table],
    make: Callable[[Table], T],
    problems: list[str],
    needed: bool = True,
) -> tuple[T, ...]:
    found = []
    for i, entry in enumerate(_tables(stated, key, problems, needed)):
        table = _validated(entry, f"{key}[{i}]", kind, problems)
        if table is None:
            continue
        try:
            found.append(make(table))
        except ValueError as error:
            problems.append(f"{key}[{i}].{error}")
    return tuple(found)


def _variables(stated: Mapping[str, Any], rig: AnyRig, problems: list[str]) -> tuple[Variable, ...]:
    found = _each(stated, "variables", VariableTable, lambda table: variable(table, rig), problems)
    problems += _each_once("variables", "name", [one.name for one in found])
    problems += _each_once("variables", "path", [one.path for one in found])
    return found


def _responses(stated: Mapping[str, Any], rig: AnyRig, problems: list[str]) -> tuple[Response, ...]:
    found: list[Response] = []
    for i, entry in enumerate(_tables(stated, "responses", problems, needed=True)):
        place = f"responses[{i}]"
        kind = _kind(entry, place, RESPONSES, problems)
        table = _validated(_without_kind(entry), place, kind, problems) if kind is not None else None
        if table is None:
            continue
        if why := table.problem(rig):
            problems.append(f"{place}.{why}")
        found.append(table)
    problems += _each_once("responses", "name", [one.name for one in found])
    return tuple(found)


def _method(stated: Mapping[str, Any], problems: list[str]) -> tuple[Method | None, str]:
    entry = stated.get("method")
    if not isinstance(entry, Mapping):
        problems.append(
            f'method: missing; add the table [method] with kind, such as kind = "sobol"; {_one_of(METHODS)}'
        )
        return None, ""
    kind = _kind(entry, "method", METHODS, problems)
    return (_validated(_without_kind(entry), "method", kind, problems) if kind else None), str(entry.get("kind"))


def _kind(entry: Mapping[str, Any], place: str, known: Mapping[str, type[T]], problems: list[str]) -> type[T] | None:
    kind = entry.get("kind")
    if kind in known:
        return known[str(kind)]
    stated = f'{place}.kind = "{kind}": unknown; {_instead(str(kind), tuple(known))}'
    problems.append(stated if kind is not None else f"{place}.kind: missing; {_one_of(known)}")
    return None


def _without_kind(entry: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in entry.items() if key != "kind"}


def _each_once(key: str, field: str, names: Sequence[str]) -> list[str]:
    return [
        f'{key}: {field} = "{n}" is there {names.count(n)} times; keep one'
        for n in dict.fromkeys(names)
        if names.count(n) > 1
    ]


def _columns(names: Sequence[str]) -> list[str]:
    """Variables and responses are columns of one table."""
    repeated = dict.fromkeys(name for name in names if names.count(name) > 1 or name in OTHER_COLUMNS)
    return [f'name = "{name}": is another column of the table already; give another name' for name in repeated]


def _one_of(known: Mapping[str, Any]) -> str:
    return f"allowed are {', '.join(known)}"


def _instead(wrong: str, known: Sequence[str]) -> str:
    close = get_close_matches(wrong, known, n=1)
    return f"did you mean {close[0]}?" if close else f"allowed are {', '.join(known)}"
