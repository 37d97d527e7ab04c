"""Run ziglang as ``cc`` beside it runs other compilers, without the checks that zig adds to code not optimised."""

import os
import sys
from importlib.machinery import PathFinder
from pathlib import Path

quick = Path(__file__).parents[1]
found = PathFinder.find_spec("ziglang", [entry for entry in sys.path if Path(entry) != quick])
os.environ["OPTIMISING_CC"] = str(Path(found.origin).with_name("zig"))
if sys.argv[-1] == "--version":  # in the names of what is cached
    print("of the tests", flush=True)
os.execv(quick / "cc", ["cc", *sys.argv[1:], "-fno-sanitize=undefined", "-fno-stack-protector"])
