"""TMN-ETM against EEM through the 120 m winding, uncoupled and coupled: ``make winding``.

Prints one table; the source's figures stand beside ours.  Takes a few minutes: EEM has 600 elements.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np

from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding as Trip
from rope_model.parameters import Mesh, Scene, rope_120

from .kinematic import Winding, progress_bar, wind

SOURCE_SAVED = {"uncoupled": 86.5, "coupled": 92.7}  # % of the computation time


def run(scene: Scene, name: str) -> Winding:
    """One winding of 90 m with a progress bar."""
    reference = s_curve(Trip())
    with progress_bar(name, reference.duration + 3.0) as advance:
        return wind(scene, reference, 90.0, progress=advance)


#: meshes that show why the default is as it is
VARIANTS = {
    "default": Mesh("auto"),
    "l = 2 m": Mesh(),
    "ends not halved (the source's pattern)": Mesh(end_levels=0),
    "segment IV of 24 elements, l = 1.6 m": Mesh(coarse_length=1.6, counts=(8, 8, 24, 8, 8)),
}


def variants(scene: Scene, eem: Winding) -> list[str]:
    """A line for each of VARIANTS."""
    lines = []
    for name, mesh in VARIANTS.items():
        tmn = run(scene.with_(mesh=mesh), name)
        bottom = 1e3 * np.abs(np.array(tmn.bottom) - eem.bottom).max()
        potential = np.abs([e.potential for e in tmn.events if e.what == "transformation"])
        counts = tmn.rope.state.counts
        lines.append(
            f"{name:<40}{tmn.rope.state.partition.lengths.size:>4} elements, loop bottom {bottom:5.2f} mm, potential "
            f"energy per transformation up to {potential.max():.1e} J, {counts.rejections} rejected steps"
        )
    return lines


def compare(coupling: str) -> tuple[list[tuple[str, str]], list[str]]:
    """Rows of the table for one of ``uncoupled`` and ``coupled``, and lines on other meshes for the latter."""
    case = rope_120()
    rope = case.scene.rope if coupling == "coupled" else replace(case.scene.rope, Qb=0.0, Qc=0.0)
    scene = case.scene.with_(rope=rope)
    tmn = run(scene, f"TMN-ETM, {coupling}")
    eem = run(scene.with_(mesh=Mesh(kind="eem", elements=600)), f"EEM, {coupling}")
    largest = np.abs(eem.force).max()
    force = np.sqrt(np.mean((np.array(tmn.force) - eem.force) ** 2)) / largest
    bottom = 1e3 * np.abs(np.array(tmn.bottom) - eem.bottom).max(axis=0)
    observed = np.abs(np.array(tmn.observed) - eem.observed).max(axis=(0, 1))
    kinetic = np.abs(np.array(tmn.kinetic) - eem.kinetic).max()
    changes = np.abs([(e.kinetic, e.potential) for e in tmn.events if e.what == "transformation"])
    elements = [w.rope.state.partition.lengths.size for w in (tmn, eem)]
    rows = [
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
        ("residual of the energy balance with TMN-ETM", f"{tmn.rope.state.energy_balance.residual:.2f} J"),
        ("computation time, TMN-ETM / EEM", f"{tmn.cpu:.2f} / {eem.cpu:.2f} s"),
        (
            "computation time saved",
            f"{100 * (1 - tmn.cpu / eem.cpu):.1f} %   (source: {SOURCE_SAVED[coupling]} % with its own code)",
        ),
    ]
    return rows, variants(scene, eem) if coupling == "coupled" else []


def main() -> None:
    """Print both tables."""
    argparse.ArgumentParser("python -m benchmarks.winding", description=__doc__).parse_args()
    for coupling in ("uncoupled", "coupled"):
        rows, lines = compare(coupling)
        print(f"\n120 m winding, 90 m at up to 8 m/s, {coupling}")
        for name, value in rows:
            print(f"  {name:<48}{value}")
        for line in lines:
            print(f"  {line}")


if __name__ == "__main__":
    main()
