"""Draw the figures into docs/images: ``python -m docs.drawings``; with ``winding`` the animation, from a run, too."""

import sys
from pathlib import Path

from .figures import FIGURES

IMAGES = Path(__file__).resolve().parent.parent / "images"


def main(names: list[str]) -> None:
    """Write the files, the animation when it is named."""
    for name, draw in FIGURES.items():
        path = IMAGES / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(draw().svg(), encoding="utf-8")
    if "winding" in names:
        from .winding import winding

        (IMAGES / "winding.svg").write_text(winding().svg(), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
