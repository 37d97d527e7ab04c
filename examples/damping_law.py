"""Friction between wires against viscous damping: fits of both to a cable that rubs.

Does a swing tell one from the other? Cameras see the cable.

``python examples/damping_law.py``: one swing, then the same and one of a third of its way.
"""

from dataclasses import replace
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import camera_track as camera
import numpy as np

from hoist_demo.calibration.definition import MeasurementFile
from hoist_demo.calibration.fit import Fit, fit
from hoist_demo.calibration.identify import residuals_of, stacked
from hoist_demo.files.reading import read

#: N m2, N m: a cable of little material damping, whose wires rub
RUBS = {"EI": 8e-3, "EI_stick": 2e-2, "slip_moment": 4e-3, "slip_factor": 0.0, "beta_K": 0.01}
LAWS = {
    "viscous": "",
    "friction": (
        "rope.EI_stick = { low = 1.3e-2, high = 5e-2 }\n"
        "rope.slip_moment = { low = 1e-3, high = 2e-2 }\n"
    ),
}
WAY = camera.aside.copy()


def write_swing(folder: Path, part: float, seed: int) -> str:
    """Write a swing of this part of the way; return its [[measured]]."""
    camera.SCENE = camera.SCENE.with_(rope=replace(camera.CABLE, **RUBS))
    camera.aside = part * WAY
    camera.grippers[:, 0] = camera.aside - np.array([0.2, 0.0, 0.0])
    path = camera.write(folder, camera.marker_places(), seed)
    path.with_suffix(".csv").replace(folder / f"{seed}.csv")
    _, table, keys = path.read_text(encoding="utf-8").partition("[[measured]]")
    return table + keys.replace("swing.csv", f"{seed}.csv")


def fit_law(folder: Path, swings: str, law: str) -> tuple[MeasurementFile, Fit]:
    """Fit one law to the swings."""
    head, _, _ = (folder / "swing.toml").read_text(encoding="utf-8").partition("[[measured]]")
    head = head.replace("high = 3e-2 }\n\n[sought]", "high = 1.2e-2 }\n\n[sought]")
    head = head.replace("low = 0.01", "low = 0.001")
    path = folder / f"{law}.toml"
    head = head.replace("[fixed]", f"{LAWS[law]}[fixed]\nrope.slip_factor = 0.0")
    path.write_text(head + swings, encoding="utf-8")
    file = read(path, MeasurementFile)
    problem = file.problem
    measurements = file.measurements
    residuals = residuals_of(problem, measurements, *stacked(measurements))
    return file, fit(residuals, len(problem.names))


def main() -> None:
    """Print the misfit of each law, and the values that it finds."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        far = write_swing(folder, part=1.0, seed=1)
        near = write_swing(folder, part=1.0 / 3.0, seed=2)
        cases = {"one swing": far, "two amplitudes": far + near}
        for (title, swings), law in product(cases.items(), LAWS):
            file, found = fit_law(folder, swings, law)
            values = [
                f"{name} = {file.problem.value(name, found.norm_params):.3g}"
                for name in file.problem.names
            ]
            misfit = np.sqrt(np.mean(np.square(found.residuals)))
            print(f"{title}, {law}: {misfit:.2f} standard errors off (RMS); {', '.join(values)}")


if __name__ == "__main__":
    main()
