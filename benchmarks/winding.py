"""TMN-ETM against EEM through the 120 m winding, uncoupled and coupled: ``make winding``.

Prints one table; the source's figures stand beside ours.  Takes a few minutes: EEM has 600 elements.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from kinematic import Winding, wind
from tqdm import tqdm

from hoist_demo.parameters import Winding as Trip
from hoist_demo.reference import s_curve
from rope_model.parameters import Mesh, Scene, rope_120

SOURCE_SAVED = {"uncoupled": 86.5, "coupled": 92.7}  # % of the computation time


def run(scene: Scene, name: str) -> Winding:
    """One winding of 90 m with a progress bar."""
    reference = s_curve(Trip())
    with tqdm(total=round(reference.duration + 3.0), desc=name, unit="s", leave=False) as bar:

        def advance(t: float) -> None:
            bar.n = int(t)
            bar.refresh() if int(t * 100) % 100 == 0 else None

        return wind(scene, reference, 90.0, progress=advance)


def compare(coupling: str) -> list[tuple[str, str]]:
    """Rows of the table for one of ``uncoupled`` and ``coupled``."""
    preset = rope_120()
    rope = preset.scene.rope if coupling == "coupled" else replace(preset.scene.rope, Qb=0.0, Qc=0.0)
    scene = preset.scene.with_(rope=rope)
    tmn = run(scene, f"TMN-ETM, {coupling}")
    eem = run(scene.with_(mesh=Mesh(kind="eem", elements=600)), f"EEM, {coupling}")
    largest = np.abs(eem.force).max()
    force = np.sqrt(np.mean((np.array(tmn.force) - eem.force) ** 2)) / largest
    bottom = 1e3 * np.abs(np.array(tmn.bottom) - eem.bottom).max(axis=0)
    observed = np.abs(np.array(tmn.observed) - eem.observed).max(axis=(0, 1))
    kinetic = np.abs(np.array(tmn.kinetic) - eem.kinetic).max()
    changes = np.abs([(e.kinetic, e.potential) for e in tmn.events if e.what == "transformation"])
    elements = [w.rope.state.partition.lengths.size for w in (tmn, eem)]
    return [
        ("elements, TMN-ETM / EEM", f"{elements[0]} / {elements[1]}"),
        ("RMS end-force difference / largest force", f"{100 * force:.4f} %   (bound 0.5 %)"),
        (
            "loop bottom, largest difference in x, y, z",
            f"{bottom[0]:.2f}, {bottom[1]:.2f}, {bottom[2]:.2f} mm   (bound 10)",
        ),
        ("observation points, difference in x, z", f"{1e3 * observed[0]:.2f}, {1e3 * observed[2]:.2f} mm"),
        ("observation points, difference in theta", f"{1e3 * observed[6]:.3f} mrad"),
        ("kinetic energy, largest difference", f"{kinetic:.3f} J of {max(eem.kinetic):.0f}   (source: below 1 of 1e4)"),
        ("kinetic energy change per transformation", f"{changes[:, 0].max():.1e} J   (source: below 1e-4)"),
        ("potential energy change per transformation", f"{changes[:, 1].max():.1e} J"),
        ("transformations, rejected steps", f"{len(changes)}, {tmn.rope.state.counts.rejections}"),
        ("energy the books of TMN-ETM do not explain", f"{tmn.rope.state.ledger.residual:.2f} J"),
        ("computation time, TMN-ETM / EEM", f"{tmn.cpu:.2f} / {eem.cpu:.2f} s"),
        (
            "computation time saved",
            f"{100 * (1 - tmn.cpu / eem.cpu):.1f} %   (source: {SOURCE_SAVED[coupling]} % with its own code)",
        ),
    ]


def main() -> None:
    """Print both tables."""
    for coupling in ("uncoupled", "coupled"):
        rows = compare(coupling)
        print(f"\n120 m winding, 90 m at up to 8 m/s, {coupling}")
        for name, value in rows:
            print(f"  {name:<48}{value}")


if __name__ == "__main__":
    main()
