"""The end of pythonfmu's library, which must not be left to the library itself.

Its one static variable is a shared pointer to the state of the interpreter.  On Linux (pythonfmu 0.7.0,
PySlaveInstance.cpp) the pointer is released twice at the end of the process: by its destructor, which frees the count
of owners, and then by finalizePythonInterpreter in a destructor of the library, which counts down in the freed memory.
Where the memory's place in the free list was written there, the process aborts with "corrupted double-linked list",
after all results are out.  An empty slave suffices.  On Windows the two come in the other order, which is right.

Called before, finalizePythonInterpreter leaves the pointer empty, and both releases find nothing to do.  The
interpreter's exit is the last moment for it, and the first: a state given up earlier would end an interpreter that
pythonfmu started, and numpy cannot be loaded again by the next one.
"""

from __future__ import annotations

import atexit
import ctypes
import functools
import os
import sys
from pathlib import Path


@functools.cache
def release_at_exit(library: Path) -> None:
    """Has pythonfmu's ``library`` release the interpreter once, if it is what this process runs the FMU by."""
    if sys.platform != "linux":
        return
    try:
        loaded = ctypes.CDLL(str(library), mode=os.RTLD_NOLOAD)
    except OSError:  # the class is used without the library, as by pythonfmu's builder
        return
    finalize = loaded.finalizePythonInterpreter
    finalize.restype = None
    atexit.register(finalize)
