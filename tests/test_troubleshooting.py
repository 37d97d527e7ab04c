"""docs/reference/messages.md speaks of messages that there are, and leaves none of the rope's and the FMU's out."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "reference" / "messages.md").read_text(encoding="utf-8")
ENTRIES = re.findall(r"^### `+ ?(.*?) ?`+$", PAGE, re.M)
#: stands for a number, a name or another message
GAP = "…"
#: words from which on a text is taken for a message
WORDS = 4
CALLS = {"Status", "RopeStatus", "_fail_later", "warning"}
#: texts of the core that are no messages, or say nothing by themselves
NO_ENTRY = {
    "the rope may touch a body": "status.fidelity_reason",
    "the rope may touch itself": "status.fidelity_reason",
    "guards watch the loop": "status.fidelity_reason",
    "the air may carry the rope along": "status.fidelity_reason",
    "the rope has a permanent curvature of": "status.fidelity_reason",
    "forces are applied to places of the rope": "status.fidelity_reason",
    "forces that are applied to places of the rope": "part of 'model cannot follow'",
    "no torque acts and nothing acts out of plane": "status.fidelity_reason, not a failure",
    "model errs by an estimated": "status.fidelity_reason",
    "where the rope is initialised with its swivels held": "status.fidelity_reason",
    "tension and torsion are coupled (Qb": "status.fidelity_reason",
    "the rope is twisted by": "status.fidelity_reason",
    "while its swivels hold": "part of 'model cannot follow'",
    "it errs by an estimated": "part of 'model cannot follow'",
    "a rope that goes slack (tension": "part of 'model cannot follow'",
    "mesh.kind = auto takes them from": "an addition to the messages of the mesh",
    "the coupling Qb": "part of 'hangs yawed'",
    "installed_twist =": "part of 'hangs yawed'",
    "initial_curvature =": "part of 'hangs yawed'",
    "the ends, which twist the rope by": "part of 'hangs yawed'",
    "contact is not computed": "the end of 'have passed through each other'",
    "s on (deepest by": "part of 'the rope has passed into'",
    "an input's number is 0 to 21": "a programmer's: no host can cause it",
    "drive: … states": "what the log tells of the drive",
    "its local error": "part of 'a step of ... fails too'",
    "use mesh.fit_mesh": "a programmer's: no host can cause it",
    "give three components per place": "a programmer's, who puts forces on the rope",
    "sort the places": "a programmer's, who puts forces on the rope",
    "mend the places": "a programmer's, who puts forces on the rope",
    "give the step's ends": "a programmer's, who puts forces on the rope",
    "holds kernels of another mesh size": "part of 'does not load here'",
    "has no attribute": "a programmer's: Python's own words for a misspelt name",
    "of them too many": "part of 'are not a rope state'",
    "the licence is missing": "of a damaged installation; names its cure",
    "the reference run fails": "of the export; the cause follows",
}


def python_messages(path: Path) -> list[str]:
    """Texts of what is raised, of statuses and warnings, and sentences that functions return."""
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        parts: list[ast.expr] = []
        if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
            parts = node.exc.args
        elif isinstance(node, ast.Call) and getattr(node.func, "id", getattr(node.func, "attr", "")) in CALLS:
            parts = node.args
        elif isinstance(node, ast.Return) and node.value is not None and path.parent.name == "simulation":
            parts = [node.value]
        found += [text for part in parts if (text := literal(part))]
    return found


def literal(node: ast.expr) -> str:
    """The text of a string with gaps; '' for anything else."""
    if isinstance(node, ast.Constant):
        return re.sub(r"%[a-z]", GAP, node.value) if isinstance(node.value, str) else ""
    if isinstance(node, ast.JoinedStr):
        return "".join(literal(x) if isinstance(x, ast.Constant) else GAP for x in node.values)
    return ""


def c_messages(path: Path) -> list[str]:
    """All texts of a C file but lines of Python in it."""
    text = re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.S)
    found = re.findall(r'(?:"(?:[^"\\\n]|\\.)*"\s*)+', text)
    joined = ["".join(re.findall(r'"((?:[^"\\]|\\.)*)"', part)) for part in found]
    return [re.sub(r"%[-.\d]*l?[a-z]", GAP, part).replace("%%", "%") for part in joined if "\\n" not in part]


def strings(path: Path) -> list[str]:
    """All texts of a Python file but its docstrings."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    documentation = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    expressions = (node for node in ast.walk(tree) if isinstance(node, ast.expr) and id(node) not in documentation)
    return [text for node in expressions if (text := literal(node))]


def sources(suffix: str, *folders: str) -> list[Path]:
    return [path for folder in folders for path in sorted((ROOT / folder).rglob(f"*{suffix}"))]


@cache
def c_texts() -> list[str]:
    folders = "rope_model", "fmu_src", "hoist_demo/drive_fmu"
    files = [path for path in (*sources(".c", *folders), *sources(".h", *folders)) if path.parent.name != "include"]
    return [text for path in files for text in c_messages(path)]


@cache
def core() -> list[str]:
    """The messages of both languages."""
    python = [text for path in sources(".py", "rope_model", "fmu_src") for text in python_messages(path)]
    return sorted({text for text in c_texts() + python if len(re.findall(r"[A-Za-z]{2,}", text)) >= WORDS})


@cache
def all_texts() -> list[str]:
    files = sources(".py", "rope_model", "fmu_src", "hoist_demo")
    return c_texts() + [text for path in files for text in strings(path)]


def speaks_of(entry: str, message: str) -> bool:
    """Whether the parts of an entry's heading stand in the message, in their order."""
    return re.search(".*".join(map(re.escape, filter(None, entry.split(GAP)))), message, re.S) is not None


def test_the_messages_of_both_languages_are_found() -> None:
    for text in ("the loop hangs yawed by", "cannot advance from t =", "is an output and cannot be set"):
        assert any(text in message for message in core())
    assert any("goes beyond the stop time" in message for message in core())  # C only


@pytest.mark.parametrize("entry", ENTRIES)
def test_an_entry_speaks_of_a_message_that_there_is(entry: str) -> None:
    assert len(re.findall(r"[A-Za-z]+", entry)) >= 3
    assert any(speaks_of(entry, text) for text in all_texts())


def test_every_message_of_the_core_has_an_entry_or_a_reason_why_not() -> None:
    silent = (message for message in core() if not any(speaks_of(entry, message) for entry in ENTRIES))
    assert [message for message in silent if not any(text in message for text in NO_ENTRY)] == []


@pytest.mark.parametrize("text", NO_ENTRY)
def test_what_has_no_entry_is_still_there(text: str) -> None:
    assert any(text in message for message in core())


def test_no_message_stands_in_two_files_of_c() -> None:
    """But for one of the models in the two flavours of the rope's FMU, which share no file about ropes."""
    texts = [text for path in sources(".c", "fmu_src") for text in {*c_messages(path)} if len(text.split()) >= WORDS]
    repeated = {text for text in texts if texts.count(text) > 1}
    assert repeated == {f"there is no derivative of {GAP}; ask for those of left.fx ... left.mz, right.fx ... right.mz"}
