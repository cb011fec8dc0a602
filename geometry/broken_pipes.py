"""gmsh's start resets SIGPIPE, which Python ignores so as to raise BrokenPipeError.

A write to a worker process that is gone would then end this process without a word.
"""

import ctypes
import signal
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def broken_pipes_as_before() -> Iterator[None]:
    """What happens on writing to a broken pipe is, afterwards, what it was before.

    By the C functions, since `signal.signal` works in the main thread only.
    """
    number = getattr(signal, "SIGPIPE", None)
    if number is None:  # Windows has none
        yield
        return
    get, put = ctypes.pythonapi.PyOS_getsig, ctypes.pythonapi.PyOS_setsig
    get.restype = put.restype = ctypes.c_void_p
    put.argtypes = [ctypes.c_int, ctypes.c_void_p]
    before = get(number)
    try:
        yield
    finally:
        put(number, before)
