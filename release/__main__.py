"""Everything that is handed out, in one folder: python -m release [FOLDER].

Source distribution and wheel, the FMUs of the 120 m rope in both flavours and the system with its drive, a bill of
materials and SHA256SUMS, which ``sha256sum --check`` reads.
"""

import sys
from pathlib import Path

from hoist_demo.command_line.main import main as balance_rope
from release.bill import bill_of_materials, sha256
from release.wheels import build
from rope_model import __version__


def release(out: Path) -> list[Path]:
    """Build everything into ``out``, which has to be empty or not there."""
    if out.exists() and any(out.iterdir()):
        raise ValueError(f"{out} is not empty: remove it, or name another folder")
    files = build(out)
    if balance_rope(
        ["export", "--python", "--native", "--fmi", "2", "3", "--ssp", "--out", str(out)]
    ):
        raise RuntimeError("the FMUs cannot be exported")
    files += sorted([*out.glob("*.fmu"), *out.glob("*.ssp")])
    bill = out / f"balance_rope-{__version__}.cdx.json"
    bill.write_text(bill_of_materials(files), encoding="utf-8")
    sums = out / "SHA256SUMS"
    sums.write_text(
        "".join(f"{sha256(path)}  {path.name}\n" for path in (*files, bill)), encoding="utf-8"
    )
    return [*files, bill, sums]


if __name__ == "__main__":
    for path in release(Path(sys.argv[1] if len(sys.argv) > 1 else "dist")):
        print(f"{path}  {path.stat().st_size / 1e6:.2f} MB")
