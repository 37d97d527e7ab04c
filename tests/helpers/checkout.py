"""Folders of the checkout."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TESTS = ROOT / "tests"
HELPERS = TESTS / "helpers"
EXAMPLES = ROOT / "examples"
#: programs in C that tests compile
NATIVE = TESTS / "native"
#: compilers that optimise less, in place of those of the machine
QUICK = TESTS / "quick"
