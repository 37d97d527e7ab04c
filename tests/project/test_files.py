"""Files appear whole under their names, or not at all; every writer of the product goes through rope_model.files."""

import ast
import errno
import os
import re
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from zipfile import ZipFile

import pytest
from checkout import ROOT
from shared import Patch

from fmu_src.archive import write_archive
from rope_model import compiler as kernels
from rope_model import files
from rope_model.files import WriteError, whole_file, write_text

PRODUCT = ("rope_model", "fmu_src", "hoist_demo")
#: Calls that write a file, by the name of the function.
WRITERS = frozenset(
    {
        "write_text",
        "write_bytes",
        "savefig",
        "print_png",
        "to_csv",
        "to_parquet",
        "savez",
        "savemat",
        "savetxt",
    }
    | {"ZipFile", "copyfile", "copy2", "copytree", "move", "FileSerializer", "tofile"}
    | {"json.dump", "pickle.dump", "np.save", "pq.write_table", "shutil.copy"}
)
_LAST_NAMES = frozenset(name.rpartition(".")[2] for name in WRITERS)
#: a module without one of them is not parsed
CALLS = re.compile(
    rf"\b({'|'.join(sorted(_LAST_NAMES | {'open', 'write_text', 'write_bytes'}))})\b"
)
#: Writers of scratch files in temporary folders, and of a lock: nobody reads a part of them.
SCRATCH = {
    "fmu_src/python/export.py": 5,  # the stage of the Python FMU
    "rope_model/compiler.py": 2,  # C files to compile, the lock
    "hoist_demo/cosimulation/participants/plain_data.py": 1,  # bytes in memory
}


def writes(call: ast.Call) -> bool:
    """Return True for a call that writes a file by its path."""
    name = getattr(call.func, "attr", None) or getattr(call.func, "id", "")
    if name == "open":
        texts = [
            one.value
            for one in ast.walk(call)
            if isinstance(one, ast.Constant) and isinstance(one.value, str)
        ]
        return any(text and set(text) <= set("wxab+") for text in texts)
    if name == "ZipFile":
        return any(
            isinstance(one, ast.Constant) and one.value in ("w", "a", "x") for one in call.args
        )
    return name in WRITERS or (name in _LAST_NAMES and ast.unparse(call.func) in WRITERS)


def names_of_drafts(tree: ast.AST) -> set[str]:
    """Return the names of drafts that ``whole_file`` hands out, and of files opened there."""
    drafts = {"whole_file"}
    for one in ast.walk(tree):
        if not isinstance(one, ast.With):
            continue
        for item in one.items:
            used = {name.id for name in ast.walk(item.context_expr) if isinstance(name, ast.Name)}
            if used & drafts and isinstance(item.optional_vars, ast.Name):
                drafts.add(item.optional_vars.id)
    return drafts


def test_no_file_is_written_but_by_the_one_helper() -> None:
    paths: list[Path] = []
    for name in PRODUCT:
        paths += (ROOT / name).rglob("*.py")
    found = dict[str, list[str]]()
    helpers = {"write_text", "write_bytes"}
    for path in sorted(paths):
        if path == Path(files.__file__):
            continue
        text = path.read_text(encoding="utf-8")
        if not CALLS.search(text):
            continue
        tree = ast.parse(text)
        drafts = names_of_drafts(tree)
        for call in (one for one in ast.walk(tree) if isinstance(one, ast.Call) and writes(one)):
            uses = {one.id for one in ast.walk(call) if isinstance(one, ast.Name)}
            by_helper = isinstance(call.func, ast.Name) and call.func.id in helpers
            if not by_helper and not uses & drafts:
                found.setdefault(path.relative_to(ROOT).as_posix(), []).append(
                    f"{call.lineno}: {ast.unparse(call)}"
                )
    assert {
        name: lines for name, lines in found.items() if len(lines) != SCRATCH.get(name, 0)
    } == {}


def test_a_full_disk_leaves_the_old_file_and_no_draft(tmp_path: Path, monkeypatch: Patch) -> None:
    path = tmp_path / "signals.csv"
    write_text(path, "old\n")

    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(
        WriteError,
        match=r"signals\.csv cannot be written \(No space left on device\): make room there",
    ):
        write_text(path, "new\n")
    with pytest.raises(WriteError, match=r"a\.fmu cannot be written"):
        write_archive(tmp_path / "a.fmu", {"modelDescription.xml": b"<x/>"})
    assert [one.name for one in tmp_path.iterdir()] == ["signals.csv"]
    assert path.read_text() == "old\n"


@pytest.mark.skipif(sys.platform == "win32", reason="resource limits are of Unix")
def test_a_limit_on_file_size_is_an_error_with_exit_code_1(tmp_path: Path) -> None:
    # a process of its own: the limit stays, and a fork of this one, which has threads, may hang
    # the limit holds for Python's own caches, too: -B writes none
    code = (
        "import resource, signal, sys; from hoist_demo.command_line.main import main\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN); "
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))\n"
        "sys.exit(main(sys.argv[1:]))"
    )
    asked = [
        "new",
        "x",
        "--depth",
        "500",
        "--payload",
        "9t",
        "--speed",
        "9",
        "--out",
        str(tmp_path / "x.toml"),
    ]
    command = [sys.executable, "-B", "-c", code, *asked]
    environment = {
        **os.environ,
        "PYTHONDONTWRITEBYTECODE": "1",
        "MPLCONFIGDIR": str(tmp_path.parent),
    }
    done = subprocess.run(
        command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert (
        "x.toml cannot be written (File too large): make room there, or choose another folder"
        in done.stderr
    )
    assert [*tmp_path.iterdir()] == []


def test_two_writers_of_one_archive_do_not_meet(tmp_path: Path) -> None:
    path = tmp_path / "one.fmu"
    with whole_file(path) as slow:
        slow.write_bytes(b"half")
        write_archive(path, {"a": b"whole"})
        with ZipFile(path) as archive:
            assert archive.read("a") == b"whole"
        slow.write_bytes(b"last")
    assert path.read_bytes() == b"last"
    assert [*tmp_path.iterdir()] == [path]


def test_compiled_code_goes_where_it_can_be_written(
    tmp_path: Path, monkeypatch: Patch, caplog: pytest.LogCaptureFixture
) -> None:
    no_folder = tmp_path / "file"
    temporary = tmp_path / "tmp"
    no_folder.write_text("")
    temporary.mkdir()
    monkeypatch.delenv("BALANCE_ROPE_CACHE", raising=False)
    monkeypatch.delenv("LOCALAPPDATA", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(no_folder))
    monkeypatch.setattr(kernels.tempfile, "gettempdir", lambda: str(temporary))
    folder = kernels.cache_folder()
    assert folder.parent == temporary
    assert folder.stat().st_mode & 0o777 == 0o700
    assert "name another folder in BALANCE_ROPE_CACHE" in caplog.text
    # a folder that others can write is none to load libraries from
    other = tmp_path / "other"
    other.mkdir()
    (other / folder.name).mkdir()
    (other / folder.name).chmod(0o777)
    assert kernels._temporary_cache(other) not in (folder, other / folder.name)
    monkeypatch.setenv("BALANCE_ROPE_CACHE", str(no_folder / "x"))
    with pytest.raises(WriteError, match=r"file\.so cannot be written"):
        kernels.make_once(kernels.cache_folder() / "file.so", lambda: None)


def test_what_many_want_at_once_is_made_once(tmp_path: Path) -> None:
    file = tmp_path / "made"
    runs = []

    def make() -> None:
        runs.append(file.exists())
        time.sleep(0.1)  # the others have come
        file.write_text("whole")

    with ThreadPoolExecutor(4) as threads:
        made = [*threads.map(lambda _: kernels.make_once(file, make), range(4))]
    assert made == [file] * 4
    assert runs == [False]
    assert [*tmp_path.iterdir()] == [file]
