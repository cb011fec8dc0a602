"""All designs as one tidy table, a row a design: which of them keep the limits, which ones no other beats (the best one
of a single objective, the Pareto front of several); CSV, and Parquet with units in the columns' metadata."""

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from updamp.design.goals import Target
from updamp.design.methods.method import Problem, library
from updamp.design.records import BROKEN, FAILED, Record
from updamp.design.study_file import DesignStudy


def columns(study: DesignStudy) -> dict[str, str]:
    """Name of each column -> its unit, "" for none."""
    units = {one.name: one.unit for one in study.variables} | {one.name: one.unit for one in study.responses}
    first, last = ("number", "outcome", "feasible"), ("executed", "routes", "reason")
    return {**dict.fromkeys(first, ""), **units, "seconds": "s", **dict.fromkeys(last, "")}


def rows(study: DesignStudy, records: Sequence[Record]) -> list[dict[str, Any]]:
    """By the columns' names. feasible: None where a constraint's response is not known"""
    problem = problem_of(study)
    return [
        {
            "number": one.number,
            "outcome": one.outcome,
            "feasible": feasible(problem, one),
            **one.values,
            **one.responses,
            "seconds": one.seconds,
            "executed": ", ".join(one.executed),
            "routes": "; ".join(f"{peak}: {how}" for peak, how in one.routes.items()),
            "reason": one.reason,
        }
        for one in records
    ]


def feasible(problem: Problem, record: Record) -> bool | None:
    """None where a constraint's response is not known, and of a design that has none"""
    if record.outcome in (FAILED, BROKEN):
        return None
    violations = problem.violations(record)
    return None if violations is None else all(v <= 0 for v in violations)


def problem_of(study: DesignStudy) -> Problem:
    """To judge records by, without a method that runs."""
    names = tuple(one.name for one in study.responses)
    return Problem(study.name, study.variables, names, study.objectives, study.constraints, Path())


def best_records(problem: Problem, records: Sequence[Record]) -> tuple[Record, ...]:
    """Of those that keep all constraints, the ones that none other surpasses in an objective without being worse in
    another; by the first objective, best first, or by the sum of squares where all are targets. None where the study
    has no objective."""
    if not problem.objectives:
        return ()
    judged = [(record, problem.losses(record), problem.violations(record)) for record in records]
    kept = [(r, losses) for r, losses, v in judged if losses is not None and v is not None and max(v, default=0.0) <= 0]
    if not kept:
        return ()
    losses = np.array([found for _, found in kept])
    best = [i for i, own in enumerate(losses) if not ((losses <= own).all(axis=1) & (losses < own).any(axis=1)).any()]
    fitted = all(isinstance(one.goal, Target) for one in problem.objectives)
    return tuple(
        kept[i][0] for i in sorted(best, key=lambda i: float(losses[i] @ losses[i]) if fitted else tuple(losses[i]))
    )


def write_csv(path: Path, study: DesignStudy, records: Sequence[Record]) -> None:
    """Units stand in the head: "damper.face_length [mm]"."""
    units, text = columns(study), io.StringIO()
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow([f"{name} [{unit}]" if unit else name for name, unit in units.items()])
    for row in rows(study, records):
        lines.writerow(["" if row[name] is None else row[name] for name in units])
    _replace(path, text.getvalue().encode())


def write_parquet(path: Path, study: DesignStudy, records: Sequence[Record]) -> None:
    """Columns have the plain names. raises: ValueError where pyarrow is not installed"""
    pyarrow, parquet = library("pyarrow"), library("pyarrow.parquet")
    content, units = rows(study, records), columns(study)
    numbers = {"seconds", *(one.name for one in study.variables), *(one.name for one in study.responses)}
    kinds = {name: pyarrow.float64() if name in numbers else pyarrow.string() for name in units}
    kinds |= {"number": pyarrow.int64(), "feasible": pyarrow.bool_()}
    fields = [pyarrow.field(name, kinds[name], metadata={"unit": unit}) for name, unit in units.items()]
    data = {name: [row[name] for row in content] for name in units}
    sink = io.BytesIO()
    parquet.write_table(pyarrow.Table.from_pydict(data, schema=pyarrow.schema(fields)), sink)
    _replace(path, sink.getvalue())


def _replace(path: Path, content: bytes) -> None:
    temporary = path.with_name(f".{path.name}.tmp")
    temporary.write_bytes(content)
    temporary.replace(path)
