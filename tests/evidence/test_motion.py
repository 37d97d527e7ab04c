"""Measured motions in pickled lists: fitted, judged, and refused where they hold more than numbers."""

import pickle
import re
from pathlib import Path

import numpy as np
import pytest
from measured_tracks import EXAMPLES, camera, markers
from numpy.testing import assert_allclose

from evidence import motion


@pytest.mark.slow
def test_a_folder_of_pickled_lists_is_fitted_and_judged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    grippers = camera().grippers
    ways = camera().ways
    monkeypatch.setattr(motion, "RATE", 1.0 / camera().FRAME)
    held = [
        grippers[:, 0] - 0.02 * ways[0].T,
        *grippers.swapaxes(0, 1),
        grippers[:, 1] - 0.02 * ways[1].T,
    ]
    vertices = np.stack([*held[:2], *markers().swapaxes(0, 1), *held[2:]], axis=2)[:, [0, 2, 1]]
    vertices[:, 1] *= -1.0
    for kind in ("train", "eval"):
        (tmp_path / kind).mkdir()
        (tmp_path / kind / "1.pkl").write_bytes(pickle.dumps(vertices.tolist()))
    cable = tmp_path / "cable.toml"
    text = (EXAMPLES / "measurements" / "swing.toml").read_text(encoding="utf-8")
    text = text.replace(
        "a = 0.2, b = 0.4, c = 0.6, d = 0.8", "v2 = 0.2, v3 = 0.4, v4 = 0.6, v5 = 0.8"
    )
    cable.write_text(
        text.replace('"mm"', '"m"').replace("0.0, 1.0, 0.0", "0.0, 0.0, 1.0"), encoding="utf-8"
    )
    motion.main(str(tmp_path), str(cable), str(tmp_path))
    *found, judged = capsys.readouterr().out.splitlines()
    values = [float(line.split()[2]) for line in found]
    # without noise what is left are the splines through the ends
    assert_allclose(values, [*camera().TRUTH.values()], rtol=2e-3)
    assert re.fullmatch(r"eval-1\.csv: 0\.[01] mm", judged)
    (tmp_path / "eval" / "1.pkl").write_bytes(pickle.dumps(vertices))
    with pytest.raises(pickle.UnpicklingError, match="give pickled lists of numbers alone"):
        motion.track(tmp_path / "eval" / "1.pkl")
