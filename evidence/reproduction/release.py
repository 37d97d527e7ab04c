"""The 240 m winding whose swivels are released at t = 20 s, against the same whose swivels stay locked."""

import numpy as np
from matplotlib.figure import Figure

from benchmarks.kinematic import Winding, wind
from evidence.claims import above, below
from evidence.drawing import COLOURS, REFERENCE, figure
from evidence.reproduction.claim import Claim, Section
from evidence.tables import Array, Tables, table
from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding as Trip
from rope_model import BalanceRope, Scene, Swivel, rope_240
from rope_model.physics.node import ANGLE, SIDES

RELEASE = 20.0  # s
END = 45.0  # s
FROM = 17.0  # s, start of the swivel's record that is searched for jumps
UNTIL = 24.0  # s, its end
EVERY = 5  # samples per row of the table of the loop
SWIVEL = ("acceleration [rad/s^2]", "torque [N m]")
KINDS = "released", "locked"
#: s, stated in the source: instants of stick-slip switching
SOURCE_SWITCHING = 20.0, 20.8
#: s, the torsional wave's way along the 240 m rope: what we call near
NEAR = 240.0 / 1202.0
SOON = 30.0  # s, ten after the release


def follow(scene: Scene, name: str) -> tuple[Winding, Array]:
    """Return the case's winding and, at every communication step, SWIVEL of the right one and the loop's yaw (rad)."""
    case = rope_240()
    seen = []

    def watch(rope: BalanceRope) -> None:
        acceleration = float(rope.state.motion.a[-1, ANGLE])
        seen.append((acceleration, *rope.signals(("right.swivel.torque", "loop.yaw")).values()))

    reference = s_curve(Trip(travel=case.travel, speed=case.speed))
    run = wind(scene, reference, case.travel, END - reference.duration, 1, watch)
    return run.completed(name), np.array(seen)


def measure() -> Tables:
    """Return both runs as tables."""
    scene = rope_240().scene
    released = follow(scene, "240 m, swivels released")
    locked = follow(scene.with_(left=Swivel(), right=Swivel()), "240 m, swivels locked")
    run, seen = released
    t = np.array(run.t)
    late = t >= FROM
    swivel = {name: x[late] for name, x in zip(SWIVEL, seen.T[:2], strict=True)}
    loop = {"t [s]": t[EVERY - 1 :: EVERY]}
    half = 0.5 * scene.layout.spacing
    for kind, (each, watched) in zip(KINDS, (released, locked), strict=True):
        observed = np.array(each.observed)[EVERY - 1 :: EVERY]
        bottom = np.array(each.bottom)[EVERY - 1 :: EVERY]
        for i, side in enumerate(SIDES):
            loop[f"{kind} {side} in plane [m]"] = observed[:, i, 0] + (half, -half)[i]
            loop[f"{kind} {side} out of plane [m]"] = observed[:, i, 2]
            loop[f"{kind} {side} theta [rad]"] = observed[:, i, 6]
        loop[f"{kind} bottom z [m]"] = bottom[:, 2]
        loop[f"{kind} yaw [rad]"] = np.unwrap(watched[:, 2])[EVERY - 1 :: EVERY]
    events = [(e.t, *e.what.split(" swivel ")) for e in run.events if " swivel " in e.what]
    return {
        "release-swivel": {"t [s]": t[late], **swivel},
        "release-loop": loop,
        "release-events": table(("t [s]", "side", "what"), events),
    }


def after(tables: Tables, name: str, until: float = END) -> Array:
    """Return a column of the table of the loop, from the release on."""
    t = tables["release-loop"]
    return t[name][(t["t [s]"] > RELEASE) & (t["t [s]"] <= until)]


def change(tables: Tables, quantity: str, until: float = END) -> float:
    """Return the RMS over time and both observation points of released minus locked, after the release."""
    seen = {kind: [after(tables, f"{kind} {s} {quantity}", until) for s in SIDES] for kind in KINDS}
    differences = np.subtract(seen["released"], seen["locked"])
    return float(np.sqrt(np.mean(np.square(differences))))


def in_plane_change(tables: Tables, until: float = END) -> float:
    """Return ``change`` in plane over the RMS of the motion with locked swivels about its mean, %."""
    locked = [after(tables, f"locked {s} in plane [m]", until) for s in SIDES]
    motion = [x - x.mean() for x in locked]
    return 100 * change(tables, "in plane [m]", until) / float(np.sqrt(np.mean(np.square(motion))))


def reach(tables: Tables, kind: str) -> tuple[float, float]:
    """Return how far the loop's lowest point goes to either side of the plane after the release, m."""
    z = after(tables, f"{kind} bottom z [m]")
    return float(z.max()), float(-z.min())


def instants(tables: Tables, what: str = "") -> Array:
    """Return when the right swivel changes its phase, s."""
    t = tables["release-events"]
    return np.asarray(
        t["t [s]"][(t["side"] == "right") & (np.char.find(t["what"].astype(str), what) >= 0)]
    )


def jump(tables: Tables, quantity: str) -> float:
    """Return the median change over the sample of a right swivel's switching, over the mean of the others.

    Most of these may be 0.
    """
    t = tables["release-swivel"]
    time = t["t [s]"]
    size = np.abs(np.diff(t[quantity]))
    inside = (time[1:] > RELEASE - 0.005) & (time[1:] < UNTIL)
    switching = np.zeros(size.size, dtype=bool)
    for instant in instants(tables):
        # the release lies on a sample, whose values are still those before it
        switching[min(int(np.searchsorted(time, instant, side="right")) - 1, size.size - 1)] = True
    return float(np.median(size[inside & switching])) / float(np.mean(size[inside & ~switching]))


def claims(tables: Tables) -> list[Claim]:
    """Compare what the source says of the release."""
    first = instants(tables)[0]
    stick = instants(tables, "sticks")[0]
    ratio = change(tables, "out of plane [m]") / change(tables, "in plane [m]")
    ranges = [
        np.ptp([after(tables, f"{kind} {s} theta [rad]") for s in SIDES], axis=1) for kind in KINDS
    ]
    torsional = float((ranges[0] / ranges[1]).min())
    turn = float(
        np.max(np.abs(after(tables, "released yaw [rad]") - after(tables, "locked yaw [rad]")))
    )
    return [
        Claim(
            "in-plane motion changes little on release",
            below("RMS change / RMS motion in plane", in_plane_change(tables), 10.0, "%"),
            f"the change grows while the loop turns (by {np.degrees(turn):.0f} degrees against the locked one); it is "
            f"{in_plane_change(tables, SOON):.1f} % up to {SOON:g} s; bound and length of the run are chosen here, "
            f"and the RMS change out of plane is {ratio:.0f} times larger",
        ),
        Claim(
            "out-of-plane motion is violent after the release",
            above("RMS change out of plane / RMS change in plane", ratio, 3.0),
        ),
        Claim(
            "torsional motion is violent after the release",
            above("smallest range of theta / range with locked swivels", torsional, 1.5),
        ),
        Claim(
            "the loop swings from side to side",
            above(
                "smaller sideways amplitude of the lowest point",
                min(reach(tables, "released")),
                0.1,
                "m",
            ),
        ),
        Claim(
            "stick-slip switching near 20 s",
            below(
                "time deviation of the right swivel's first switching",
                abs(first - SOURCE_SWITCHING[0]),
                NEAR,
                "s",
            ),
        ),
        Claim(
            "stick-slip switching near 20.8 s",
            below(
                "time deviation of the right swivel's first sticking",
                abs(stick - SOURCE_SWITCHING[1]),
                NEAR,
                "s",
            ),
        ),
        *(
            Claim(
                f"switching is visible as jumps in {words}",
                above(
                    "median change at a switching / mean of other changes",
                    jump(tables, quantity),
                    10.0,
                ),
                "torsional waves also change the swivel's acceleration between switchings",
            )
            for words, quantity in (
                ("friction torque", SWIVEL[1]),
                ("angular acceleration", SWIVEL[0]),
            )
        ),
    ]


def draw(tables: Tables) -> Figure:
    """Draw the loop in and out of plane, released against locked."""
    made, axes = figure(2, 2, 5.2, sharex=True)
    t = tables["release-loop"]
    panels = {
        "left in plane [m]": "Left leg, in plane",
        "left out of plane [m]": "Left leg, out of plane",
        "bottom z [m]": "Lowest point, out of plane",
        "yaw [rad]": "Yaw of the loop",
    }
    for ax, (quantity, title) in zip(axes.flat, panels.items(), strict=True):
        ax.plot(
            t["t [s]"], t[f"locked {quantity}"], color=REFERENCE, lw=1.6, label="swivels locked"
        )
        ax.plot(
            t["t [s]"],
            t[f"released {quantity}"],
            color=COLOURS["left"],
            label="swivels released at 20 s",
        )
        ax.axvline(RELEASE, color="#c0392b", lw=0.6, alpha=0.7, zorder=0.5)
        ax.set(ylabel=quantity[quantity.index("[") :], title=title)
    for ax in axes[1]:
        ax.set_xlabel("time [s]")
    made.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return made


SECTION = Section(
    "Release of the swivels", claims, ("release-swivel", "release-loop", "release-events")
)
