"""Files for people: made again when their sources change, and never left beside a newer summary."""

import errno
import json
from pathlib import Path

import pytest
import typer

from updamp.commands.shared import clean_errors
from updamp.parallel.whole_file import DiskError
from updamp.pictures.style import figure
from updamp.workflow.output_folder import results_of_other_states
from updamp.workflow.run_outputs import Outputs


def outputs(folder: Path, state: str) -> Outputs:
    return Outputs(folder, folder / "stages" / "outputs.json", state)


def write(path: Path) -> None:
    path.write_text("x")


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir() if path.is_file()}


def test_what_is_of_an_older_state_and_not_made_again_is_removed(tmp_path: Path) -> None:
    first = outputs(tmp_path, "0.6")
    for name in ("OOP.png", "IP.png", "mesh.png"):
        assert first.make(name, ["a"], 1, write)
    assert first.remove_older() == ()
    again = outputs(tmp_path, "0.4")  # one mode alone, and its sources have changed
    assert again.make("OOP.png", ["b"], 1, write)
    assert not again.make("mesh.png", ["a"], 1, write), "made from the same sources: as it was"
    assert again.remove_older() == ("IP.png",)
    assert names(tmp_path) == {"OOP.png", "mesh.png"}
    assert outputs(tmp_path, "0.4").remove_older() == ()
    assert outputs(tmp_path, "0.6").remove_older() == ("OOP.png", "mesh.png")


def test_what_is_made_beside_a_file_goes_and_comes_with_it(tmp_path: Path) -> None:
    def both(path: Path) -> None:
        write(path)
        write(path.with_suffix(".svg"))

    first = outputs(tmp_path, "0.6")
    assert first.make("OOP.png", ["a"], 1, both, (".svg",))
    assert not first.make("OOP.png", ["a"], 1, both, (".svg",))
    (tmp_path / "OOP.svg").unlink()
    assert first.make("OOP.png", ["a"], 1, both, (".svg",)), "one of the two is missing"
    assert outputs(tmp_path, "0.4").remove_older() == ("OOP.png",)
    assert names(tmp_path) == set()


def test_a_part_of_the_same_study_leaves_the_rest(tmp_path: Path) -> None:
    for name in ("OOP.png", "IP.png"):
        outputs(tmp_path, "0.6").make(name, ["a"], 1, write)
    part = outputs(tmp_path, "0.6")
    assert not part.make("OOP.png", ["a"], 1, write)
    assert part.remove_older() == ()
    assert names(tmp_path) == {"OOP.png", "IP.png"}


def test_a_record_from_before_states_were_kept_removes_nothing(tmp_path: Path) -> None:
    (tmp_path / "stages").mkdir()
    (tmp_path / "stages" / "outputs.json").write_text(json.dumps({"IP.png": "key"}))
    write(tmp_path / "IP.png")
    assert outputs(tmp_path, "0.6").remove_older() == ()
    assert names(tmp_path) == {"IP.png"}


def test_comparisons_of_another_state_are_named(tmp_path: Path) -> None:
    (tmp_path / "comparison.json").write_text('{"provenance": {"state of the rig": "a"}}')
    (tmp_path / "diagnosis.json").write_text('{"provenance": {"rig": "mine"}}')
    assert results_of_other_states(tmp_path, "a") == []
    assert results_of_other_states(tmp_path, "b") == ["comparison.json"], "the diagnosis does not say"
    (tmp_path / "comparison.json").write_text("[")
    assert results_of_other_states(tmp_path, "b") == []


def _full(path: Path) -> None:  # noqa: ARG001
    """What the system raises while a file is written to a full disk: it has no name."""
    raise OSError(errno.ENOSPC, "No space left on device")


def test_a_full_disk_is_told_with_the_file(tmp_path: Path) -> None:
    with pytest.raises(DiskError, match=r"OOP\.png: cannot be written to the disk: No space left.*make room"):
        outputs(tmp_path, "").make("OOP.png", ["a"], 1, _full)


def test_a_picture_that_the_disk_does_not_take_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(DiskError, match=r"a\.png: cannot be written"), figure(tmp_path / "file" / "a.png", 1, 1):
        pass


def test_what_nobody_nearer_told_of_the_disk_says_what_to_do(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    with pytest.raises(typer.Exit), clean_errors(debug=False):
        _full(tmp_path)
    said = capsys.readouterr().err
    assert "[Errno" not in said
    assert all(words in said for words in ("No space left on device", "--out", "run the same again"))
