"""Everything that a study leaves for people and other programs."""

from rich.table import Table

from updamp.design.page.page import write_page
from updamp.design.pareto import best_records
from updamp.design.run_study import StudyResult
from updamp.design.study_json import write_study_json
from updamp.design.table import problem_of, write_csv, write_parquet

_SHOWN = 12  # designs on the terminal


def write_outputs(result: StudyResult) -> tuple[str, ...]:
    """Names of the files. raises: ValueError where pyarrow is missing; OSError where a file cannot be written"""
    folder = result.folder.path
    write_csv(folder / "designs.csv", result.study, result.records)
    write_parquet(folder / "designs.parquet", result.study, result.records)
    write_study_json(folder / "study.json", result)
    write_page(folder / "study.html", result)
    return "designs.csv", "designs.parquet", "study.json", "study.html"


def best_table(result: StudyResult) -> Table:
    """The best designs, or the first ones where the study has no objective."""
    study = result.study
    best = best_records(problem_of(study), result.records)
    title = "Best designs" if study.objectives else "Designs"
    table = Table(title=title, title_justify="left", header_style="bold", box=None, padding=(0, 2, 0, 0))
    names = [*((one.name, one.unit) for one in study.variables), *((one.name, one.unit) for one in study.responses)]
    table.add_column("design", justify="right")
    for name, unit in names:
        table.add_column(f"{name} \\[{unit}]" if unit else name, justify="right", overflow="fold")
    for record in (best or (() if study.objectives else result.records))[:_SHOWN]:
        known = {**record.values, **record.responses}
        values = [known.get(name) for name, _ in names]
        table.add_row(str(record.number), *("not known" if v is None else f"{v:.5g}" for v in values))
    return table
