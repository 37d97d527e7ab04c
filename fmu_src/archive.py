"""Reproducible FMU archives: sorted, deflated entries without time stamps."""

import zipfile
from collections.abc import Mapping
from pathlib import Path

from rope_model.files import whole_file


def write_archive(destination: Path, files: Mapping[str, bytes]) -> None:
    """Write an archive that replaces ``destination`` at once.

    ``files`` are contents by path with forward slashes.
    """
    destination.parent.mkdir(parents=True, exist_ok=True)
    with (
        whole_file(destination) as draft,
        zipfile.ZipFile(draft, "w", zipfile.ZIP_DEFLATED) as archive,
    ):
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # Unix, which otherwise depends on the platform
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, files[name])


def read_archive(path: Path) -> dict[str, bytes]:
    """Return the contents of an archive by path, with forward slashes."""
    with zipfile.ZipFile(path) as archive:
        return {name.replace("\\", "/"): archive.read(name) for name in archive.namelist()}
