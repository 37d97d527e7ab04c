"""What docs/promise.md says, computed from the table of scenes."""

import numpy as np

from evidence.promise import scenes
from evidence.promise.judging import ESTIMATES, NEAR, claims, completed, near, over_asked
from evidence.promise.wind import FINE, FINE_STEP, REQUESTS
from evidence.rendering import number, quantity, render
from evidence.tables import Table, Tables, where

WORST = 3


def page(tables: Tables) -> str:
    """The whole page."""
    t = tables["scenes"]
    done = completed(t)
    data = {
        "drawn": scenes.SCENES,
        "fine": FINE,
        "step": FINE_STEP,
        "scenes": scenes,
        "number": len(done["kind"]),
        "longest": done["length [m]"].max(),
        "shortest": done["length [m]"].min(),
        "factor": NEAR,
        "failures": sorted({*t["failure"].tolist()} - {""}),
        "claims": [
            (
                c.what,
                number(c.value, ".3g"),
                f"{c.relation} {c.bound:.3g}",
                "yes" if c.holds else "**no**",
            )
            for c in claims(t)
        ],
        "requests": [_request(t, asked) for asked in REQUESTS],
        "groups": _groups(done),
        "worst": _worst(done),
        "fine_run": [
            quantity(np.median(done["end force, of the fine run"]), "%", ".1g"),
            quantity(np.median(done["loop, of the fine run [m]"]), "mm", ".1g"),
        ],
    }
    return render("promise/promise.md.j2", data)


def _request(all_scenes: Table, asked: str) -> tuple[str, ...]:
    """What is asked, what the errors are of that, and the work over that of the default."""
    t = completed(all_scenes, asked)
    default = completed(all_scenes)
    request = REQUESTS[asked]
    over = over_asked(t, asked)
    work = dict(zip(default["scene"].tolist(), default["work"].tolist(), strict=True))
    paid = [
        w / work[k]
        for k, w in zip(t["scene"].tolist(), t["work"].tolist(), strict=True)
        if k in work
    ]
    return (
        f"{asked}: {quantity(request.end_force, '%', 'g')}, {quantity(request.loop, 'mm', 'g')}",
        f"{np.sum(over <= 1)} of {len(over)}",
        number(float(over.max()), ".2g"),
        number(float(np.median(over)), ".2g"),
        *(quantity(near(t, x), "%") for x in ESTIMATES),
        number(float(np.median(paid)), ".2g"),
    )


def _groups(t: Table) -> list[tuple[str, ...]]:
    """Kinds of trips, long communication steps and scenes with many events."""
    groups = {kind: t["kind"] == kind for kind in scenes.KINDS}
    groups["steps of 40 and 50 ms"] = t["interval [s]"] > 0.03
    groups["ten swivel events and more"] = t["events"] > 9.5
    rows = []
    for name, mine in groups.items():
        if mine.any():
            part = where(t, mine)
            over = over_asked(part)
            shares = [float(np.mean(over <= 1)), *(near(part, x) for x in ESTIMATES)]
            rows.append(
                (
                    name,
                    str(mine.sum()),
                    number(float(over.max()), ".2g"),
                    *(quantity(x, "%") for x in shares),
                )
            )
    return rows


def _worst(t: Table) -> list[tuple[str, ...]]:
    rows = []
    for k in (-over_asked(t)).argsort()[:WORST]:
        names = (x for estimate in ESTIMATES.values() for x in estimate)
        errors = [
            quantity(t[name][k], unit, ".2g")
            for name, unit in zip(names, ("%", "%", "mm", "mm"), strict=True)
        ]
        rows.append(
            (
                f"{t['scene'][k]:.0f}, {t['kind'][k]}",
                quantity(t["length [m]"][k], "m", ".4g"),
                f"{number(t['EI [N m2]'][k])} N m^2",
                quantity(t["interval [s]"][k], "ms", "g"),
                *errors,
            )
        )
    return rows
