"""What a newcomer gets wrong ends in one clear sentence: the input, the value, the remedy; and before any work."""

from collections import Counter
from pathlib import Path

import pytest
from support.broken.folders import FOLDERS
from support.broken.measurements import MEASUREMENTS
from support.broken.outcome import Broken, Outcome, outcome
from support.broken.rig_files import RIG_FILES

BROKEN = [*RIG_FILES, *MEASUREMENTS, *FOLDERS]


@pytest.mark.parametrize("case", BROKEN, ids=lambda case: case.name)
def test_it_is_clear_what_is_wrong(case: Broken, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "10000")
    monkeypatch.chdir(tmp_path)
    found, said = outcome(case, tmp_path)
    assert found is Outcome.CLEAR, f"{found.value}, wanted {case.words}: {said}"


def test_every_input_is_another_one() -> None:
    assert [name for name, times in Counter(case.name for case in BROKEN).items() if times > 1] == []
