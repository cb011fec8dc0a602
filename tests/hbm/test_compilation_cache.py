"""What is compiled in one process is read back in the next, with the same result."""

import os
import subprocess
import sys
from pathlib import Path

from updamp.hbm.compilation_cache import keep_compiled

CODE = """
import logging, sys
import jax
import numpy as np
from updamp.hbm import compilation_cache
from updamp.hbm.contact.compiled import iwan
from updamp.hbm.contact.coulomb_circle import CoulombCircle
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.iwan import IwanMicroslip, IwanParameters
from updamp.hbm.problem.elements import ElementGroup, force_only
from updamp.hbm.harmonics import Harmonics

compilation_cache.LEAST_SECONDS = 0.0
hits = []
jax.monitoring.register_event_listener(lambda event, **_: hits.append(event) if event.endswith("cache_hits") else None)
print(compilation_cache.keep_compiled())
one = np.ones(2)
p = FrictionParameters(one, one, one, one, np.zeros((2, 2)), 0 * one)
x = np.random.default_rng(1).normal(size=(2, 3, 2))
joint = IwanParameters(one, 0.5 * one, 0 * one)  # of the laws that numba compiles the one that takes least
for law, of, motion in ((CoulombCircle(2), p, x), (IwanMicroslip(2), joint, 1e-5 * x[:, :1])):
    rows = np.arange(motion[..., 0].size).reshape(motion.shape[:2])
    print(force_only(ElementGroup(law, of, rows), motion, 1.0, Harmonics((1,)), 16).tobytes().hex())
print(len(hits), sum(iwan.force_with_tangent.stats.cache_hits.values()))
"""


def run(cache: Path) -> list[str]:
    environment = os.environ | {"XDG_CACHE_HOME": str(cache)}
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", CODE], env=environment, check=True, capture_output=True, text=True
    ).stdout.splitlines()


def test_second_process_reads_what_the_first_has_compiled(tmp_path):
    first, second = run(tmp_path), run(tmp_path)
    assert Path(first[0]).parent == tmp_path / "updamp" / "compiled"
    assert list(Path(first[0]).iterdir())
    assert first[3] == "0 0"
    assert all(int(hits) > 0 for hits in second[3].split())
    assert second[1:3] == first[1:3]


def test_laws_compiled_by_numba_work_where_nothing_can_be_written(tmp_path):
    (tmp_path / "file").write_text("not a folder")
    code = "from updamp.hbm.contact.compiled import iwan as law; print(law.force_with_tangent.stats)"
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path / "file")}
    subprocess.run([sys.executable, "-W", "error", "-c", code], env=environment, check=True)


def test_where_nothing_can_be_written_nothing_is_kept(tmp_path):
    (tmp_path / "file").write_text("not a folder")
    assert keep_compiled(tmp_path / "file") is None
