"""HTML reports in a headless browser.

Each page is opened in a frame of a given width, with a probe behind its scripts that touches it and sends what it saw
to the frame's parent.  What the browser complains about comes on stderr.
"""

import html
import json
import math
import re
import shutil
import subprocess
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.parameters import Hoist, Winding
from hoist_demo.recording.time_series import Recording
from hoist_demo.report.html.run import run_report
from hoist_demo.report.rows import Report
from hoist_demo.report.verdict import judge

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
BROWSER = next((path for name in BROWSERS if (path := shutil.which(name))), None)

POINTS = 41
STEPS = 301
END = 12.0

_FRAME = """<!DOCTYPE html><html><body><iframe src="{page}" style="width:{width}px;height:800px"></iframe>
<pre id="seen"></pre><script>
addEventListener("message", (event) => document.getElementById("seen").textContent = event.data);
</script></body></html>"""

_PROBE = """<script>
const seen = {{}};
const wait = (ms) => new Promise((done) => setTimeout(done, ms));
const press = (element, at) => {{
  const box = element.getBoundingClientRect();
  const where = {{clientX: box.left + at[0] * box.width, clientY: box.top + at[1] * box.height, bubbles: true}};
  for (const kind of ["pointerdown", "pointerup"])
    element.dispatchEvent(new PointerEvent(kind, {{...where, buttons: 1}}));
}};
const common = () => ({{
  requests: performance.getEntriesByType("resource").map((entry) => entry.name),
  width: document.documentElement.scrollWidth, room: document.documentElement.clientWidth,
}});
(async () => {{ await wait(50); {touches}; parent.postMessage(JSON.stringify({{...seen, ...common()}}), "*"); }})();
</script></body>"""


def look(page: Path, touches: str, width: int, fragment: str = "") -> SimpleNamespace:
    """Open a copy of the page with the probe in it; what the probe ``said``, and the browser's ``console``."""
    folder = page.parent / f"{page.stem}-{width}"
    folder.mkdir()
    probed = page.read_text(encoding="utf-8").replace("</body>", _PROBE.format(touches=touches))
    (folder / "page.html").write_text(probed, encoding="utf-8")
    (folder / "frame.html").write_text(
        _FRAME.format(page=f"page.html#{fragment}", width=width), encoding="utf-8"
    )
    assert BROWSER is not None
    command = [
        BROWSER,
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        f"--user-data-dir={folder / 'profile'}",
    ]
    command += [
        "--enable-logging=stderr",
        "--virtual-time-budget=8000",
        "--dump-dom",
        f"{folder / 'frame.html'}",
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    found = re.search(r'<pre id="seen">(.+?)</pre>', done.stdout, re.DOTALL)
    console = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    assert found, f"the probe said nothing; the browser: {console or done.stderr[-2000:]}"
    return SimpleNamespace(said=json.loads(html.unescape(found[1])), console=console)


def bottom(t: float) -> tuple[float, float, float]:
    """Lowest point of the invented rope at time t [s]."""
    return 0.05 * t, -15.0 - 0.1 * t, 0.02 * t


def curve(t: float) -> np.ndarray:
    """A half circle of radius 1 m below two straight legs, shape (POINTS, 3)."""
    x, y, z = bottom(t)
    angle = np.linspace(-math.pi / 2.0, math.pi / 2.0, POINTS - 2)
    loop = np.column_stack([x + np.sin(angle), y + 1.0 - np.cos(angle), np.full(POINTS - 2, z)])
    return np.vstack([[-1.0, 7.0 * t, 0.0], loop, [1.0, 90.0 - 7.0 * t, 0.0]])


def shaped(shapes: np.ndarray) -> dict[str, np.ndarray]:
    signals = {}
    for k, axis in enumerate("xyz"):
        for i in range(POINTS):
            signals[f"shape.{axis}[{i + 1}]"] = shapes[:, i, k]
    return signals


def result(signals: dict[str, np.ndarray], cause: str = "", **units: str) -> SimpleNamespace:
    """What a run leaves that was stopped by a cause, or completed."""
    trajectory = SimpleNamespace(duration=9.0) if signals else None
    return SimpleNamespace(
        recording=Recording(signals, units),
        completed=not cause,
        cause=cause,
        trajectory=trajectory,
        warning="",
        winding=Winding(),
    )


def run(tmp_path: Path, **more: np.ndarray) -> Path:
    """A trip of an invented rope, with what there is along it."""
    t = np.linspace(0.0, END, STEPS)
    shapes = np.array([curve(float(s)) for s in t])
    still = np.full(STEPS, 1.0)
    signals = {
        "time": t,
        "reference.position": 7.0 * t,
        "reference.speed": 7.0 * still,
        "conveyance.left.y": 7.0 * t,
        "conveyance.right.y": 90.0 - 7.0 * t,
        "conveyance.left.vy": 7.0 + np.sin(t),
        "drive.tension_ratio": 1.2 + 0.1 * np.sin(t),
        "left.fy": -1e3 * (5.0 + t),
        "left.swivel.slipping": ((t > 2.0) & (t < 3.0)).astype(float),
        "right.swivel.slipping": 0.0 * t,
        "count.transformations": np.floor(t / 2.0),
        "stress.bending_max": 3.6e7 + 1e5 * np.sin(t),
        "loop.clearance": 2.0 * still,
        "loop.broken": math.nan * still,
    }
    for i in range(POINTS):
        signals[f"shape.bending[{i + 1}]"] = 1e5 * still
        signals[f"shape.torsion[{i + 1}]"] = 0.0 * t
        signals[f"shape.tension[{i + 1}]"] = 80.0 * shapes[:, i, 1]
    signals[f"shape.bending[{POINTS // 2 + 1}]"] = 4e7 * still
    wound = result(signals | shaped(shapes) | more, **{"left.fy": "N", "conveyance.left.y": "m"})
    wound.winding = Winding(emergency_at=5.0)
    rope = RopeData({}, {"right.swivel.mode": 0}, {})
    report = Report("A <trip> & its rope", judge(wound, Hoist(), [rope]))
    return run_report(wound, Hoist(), report, tmp_path / "run.html", [rope])
