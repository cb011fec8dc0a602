"""Compiled contact laws kept between runs: a law takes 5 to 45 s to compile and 1 to 2 s to be read back.

JAX keys the files by what was compiled and by its own version, not by the processor: each kind of processor gets a
folder of its own, so that a home that several machines share does no harm. Results are the same to the last bit.
"""

import hashlib
import os
import platform
from pathlib import Path

import jax

# What compiles in less is compiled again sooner than read back.
LEAST_SECONDS = 0.5


def keep_compiled(folder: Path | None = None) -> Path | None:
    """Keep what is compiled from now on, and use what is there; call it once a process, before anything is solved.

    folder: by default updamp/compiled in the user's cache folder ($XDG_CACHE_HOME, or ~/.cache)
    returns: the folder in use; None where it cannot be written, and nothing is kept
    """
    place = (folder or cache_folder()) / _processor()
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    if not os.access(place, os.W_OK):
        return None
    jax.config.update("jax_compilation_cache_dir", str(place))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", LEAST_SECONDS)
    return place


def keeps_compiled() -> bool:
    """Whether this process does."""
    return jax.config.values["jax_compilation_cache_dir"] is not None


def cache_folder() -> Path:
    """Where this user keeps what is compiled; it need not be there."""
    stated = os.environ.get("XDG_CACHE_HOME", "")
    return (Path(stated) if stated else Path.home() / ".cache") / "updamp" / "compiled"


def _processor() -> str:
    """Its architecture and a hash of the instructions it knows."""
    known = platform.processor() + platform.platform()
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        known = next((line for line in lines if line.startswith(("flags", "Features"))), known)
    except OSError:  # not on Linux
        pass
    return f"{platform.machine()}-{hashlib.sha256(known.encode()).hexdigest()[:12]}"
