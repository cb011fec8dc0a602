"""Everything that a study leaves for people and other programs."""

from rich.markup import escape
from rich.table import Table

from updamp.design.page.page import write_page
from updamp.design.run_study import StudyResult
from updamp.design.study_json import write_study_json
from updamp.design.table import best_records, problem_of, write_csv, write_parquet
from updamp.pictures.corner import corner, drawn_of

_SHOWN = 12  # designs on the terminal at most
_VALUE, _BETWEEN = 9, 2  # characters of a value, and to the next one


def write_outputs(result: StudyResult) -> tuple[str, ...]:
    """Names of the files. raises: ValueError where pyarrow is missing; OSError where a file cannot be written"""
    folder = result.folder.path
    write_csv(folder / "designs.csv", result.study, result.records)
    write_parquet(folder / "designs.parquet", result.study, result.records)
    write_study_json(folder / "study.json", result)
    write_page(folder / "study.html", result)
    return "designs.csv", "designs.parquet", "study.json", "study.html", *_posterior(result)


def _posterior(result: StudyResult) -> tuple[str, ...]:
    """Where the method gives one: its draws as a table, and their picture."""
    draws = result.method.draws if result.method else {}
    if not draws:
        return ()
    folder, variables = result.folder.path, result.study.variables
    units = {one.name: one.unit for one in variables}
    lines = [",".join(f"{name} [{units[name]}]" if units[name] else name for name in draws)]
    lines += [",".join(f"{value:.6g}" for value in row) for row in zip(*draws.values(), strict=True)]
    (folder / "posterior.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    corner(folder / "posterior.png", drawn_of(draws, units, {one.name: (one.lower, one.upper) for one in variables}))
    return "posterior.csv", "posterior.png"


def best_table(result: StudyResult, width: int) -> Table:
    """The best designs, or the first ones where the study has no objective; a column each, as many as a terminal of
    this width [characters] holds."""
    study = result.study
    best = best_records(problem_of(study), result.records)
    title = "Best designs" if study.objectives else "Designs"
    table = Table(title=title, title_justify="left", header_style="bold", box=None, padding=(0, _BETWEEN, 0, 0))
    units = {one.name: one.unit for one in study.variables} | {one.name: one.unit for one in study.responses}
    names = {name: f"{name} [{unit}]" if unit else name for name, unit in units.items()}
    room = width - max(len(name) for name in names.values()) - _BETWEEN
    number = min(_SHOWN, max(1, room // (_VALUE + _BETWEEN)))
    shown = (best or (() if study.objectives else result.records))[:number]
    table.add_column("design")
    for record in shown:
        table.add_column(str(record.number), justify="right", min_width=_VALUE)
    for name, heading in names.items():
        values = [{**record.values, **record.responses}.get(name) for record in shown]
        table.add_row(escape(heading), *("not known" if v is None else f"{v:.4g}" for v in values))
    return table
