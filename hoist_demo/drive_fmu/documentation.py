"""Documents inside the drive's FMU: documentation/index.html and a picture."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.resources import files

from hoist_demo.drive_fmu.interface import Variable
from hoist_demo.parameters import ASSUMED_DATA
from rope_model.texts import html_text

_ABOUT = """\
<p>{description}.</p>
<p>The inputs are the balance rope's vertical forces on the two conveyances, held over a communication step; feed back
the <em>mean</em> forces of the rope's last step. The outputs <code>left.y</code>, <code>left.vy</code>,
<code>left.ay</code> and those on the right have the names of the rope's inputs: connect equal names, and leave the
rope's <code>inputs_at_step_end</code> false where the tool steps both at the same time. A hoist with play between
conveyances and guides has more of them: the rope's horizontal forces and its moment about the vertical in, the motions
that follow out.</p>
<p>Before the first step the drive is at rest under the forces at the start, its motor holding the imbalance. It waits
<code>trip.start</code> seconds, then follows an S-curve of limited jerk; the trip is part of the export.</p>
<h2>Equations</h2>
<p>Generalised coordinates q = (sheave angle, heights of both suspensions). Lagrange's equation
d/dt &part;K/&part;q' &minus; &part;K/&part;q + &part;V/&part;q + &part;D/&part;q' = Q with the energies of conveyances,
sheave and elastic head ropes of changing length; motor torque with a lag, losses at the rim. The classical
Runge-Kutta method with steps of at most <code>solver.step_max</code>.</p>
<p>Controller, once per communication step: M = R [m a_ref + imbalance + losses + k_v e + I],
e = v_ref + k_s (s_ref &minus; s) &minus; v, I grows by H k_v e / T_i; the torque is limited, and I stands still while
it would push further into the limit.</p>"""


def attachments(description: str, table: Sequence[Variable]) -> dict[str, bytes]:
    """Files by their paths in the FMU."""
    return {
        "documentation/index.html": _page(description, table).encode(),
        "model.png": files(__package__).joinpath("icon.png").read_bytes(),
    }


def _page(description: str, table: Sequence[Variable]) -> str:
    rows = "\n".join(
        f"<tr><td><code>{html_text(v.name)}</code></td><td>{v.causality}</td><td>{html_text(v.unit)}</td>"
        f"<td>{'' if v.start is None else f'{v.start:g}'}</td><td>{html_text(v.description)}</td></tr>"
        for v in table
    )
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>HoistDrive</title>
<style>
body {{ font: 15px/1.5 sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #222; }}
table {{ border-collapse: collapse; font-size: .9em; }}
td, th {{ padding: .2rem .6rem; border-bottom: 1px solid #ddd; text-align: left; vertical-align: top; }}
</style>
</head>
<body>
<h1>HoistDrive</h1>
{_ABOUT.format(description=html_text(description))}
<p><strong>Assumed data.</strong> {html_text(ASSUMED_DATA)}</p>
<h2>Variables</h2>
<table>
<tr><th>name</th><th>causality</th><th>unit</th><th>start</th><th>description</th></tr>
{rows}
</table>
</body>
</html>
"""
