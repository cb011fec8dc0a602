"""What is compiled is kept between processes, and compiled once by those that begin together."""

from multiprocessing import get_context
from pathlib import Path

import pytest
from support.kept_function import compile_it


@pytest.mark.long
def test_processes_that_begin_together_compile_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    context = get_context("spawn")
    together, found = context.Barrier(3), context.Queue()
    workers = [context.Process(target=compile_it, args=(together, found)) for _ in range(3)]
    for worker in workers:
        worker.start()
    counts = [found.get(timeout=120) for _ in workers]
    for worker in workers:
        worker.join()
    assert sorted(counts) == [(0, 1), (0, 1), (1, 0)]
