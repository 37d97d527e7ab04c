"""The rope's C for an editor: ``python -m release.editor FOLDER``."""

import json
import sys
from pathlib import Path

from rope_model.codegen.build import sources, written
from rope_model.compiler import FLAGS


def lay_out(folder: Path) -> None:
    """Put all C into ``folder``: links to written files, generated files, compile_commands.json."""
    folder = folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    links, commands = {path.name: path for path in written()}, []
    for name, text in sources().items():
        (folder / name).unlink(missing_ok=True)
        if name in links:
            (folder / name).symlink_to(links[name])
        else:
            (folder / name).write_text(text, encoding="utf-8")
        if name.endswith(".c"):
            commands.append(
                {"directory": str(folder), "file": name, "arguments": ["cc", *FLAGS, "-c", name]}
            )
    (folder / "compile_commands.json").write_text(json.dumps(commands, indent=1), encoding="utf-8")


if __name__ == "__main__":
    lay_out(Path(sys.argv[1]))
