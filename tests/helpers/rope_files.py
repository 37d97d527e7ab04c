"""Files on ropes for tests: a rope of the catalogue, a measurement at rest; written to a folder."""

from pathlib import Path

ROPE = '[rope]\nconstruction = "34x7"\ndiameter = 0.046\nlength = 120.0\n'
AT_REST = '[[measured]]\nwhat = "at rest"\nleft_y = 0.0\nright_y = 40.0\n'


def written(folder: Path, text: str) -> Path:
    """Write the text to a file in the folder, and return its path."""
    path = folder / "measured.toml"
    path.write_text(text, encoding="utf-8")
    return path
