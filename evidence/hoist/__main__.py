"""Wind every case, stop one, write figures, data and the table of docs/howto/hoist.md: ``make hoist`` (1 min)."""

from __future__ import annotations

import argparse

import matplotlib
import numpy as np

from evidence.pages import BLOCKS, fill
from evidence.rendering import DOCS
from evidence.tables import table, write
from hoist_demo.cases.installed import INSTALLED
from hoist_demo.parameters import EmergencyLaw

from .figures import SHOWN, creep, cycle, emergency_stops
from .page import SUMMARY, summary
from .winding import COLUMNS, Run, stop, wind

STOP_AT = 40.0  # s
LAWS: tuple[EmergencyLaw, ...] = ("deceleration", "torque", "two-stage")


def main() -> None:
    """Measure, write, and print the stops."""
    argparse.ArgumentParser("python -m evidence.hoist", description=__doc__).parse_args()
    data, images = DOCS / "data" / "hoist", DOCS / "images" / "hoist"
    images.mkdir(parents=True, exist_ok=True)
    runs = {name: wind(case.hoist, case.winding, case.gains) for name, case in INSTALLED.items()}
    stops: dict[str, Run] = {law: stop(SHOWN, law, STOP_AT) for law in LAWS}
    names = [f"{column} [{unit}]" for column, unit in COLUMNS.items()]
    kept = {"cycle": runs[SHOWN], **{f"stop-{law}": run for law, run in stops.items()}}
    cases = table(SUMMARY, [summary(name, run) for name, run in runs.items()])
    write({"cases": cases, **{name: table(names, run.table[::5].tolist()) for name, run in kept.items()}}, data)
    with matplotlib.rc_context({"font.size": 9.0}):
        figures = {"cycle": cycle(runs[SHOWN]), "stops": emergency_stops(stops, STOP_AT), "creep": creep()}
        for name, figure in figures.items():
            figure.savefig(images / f"{name}.png", dpi=110, metadata={"Software": None})
    fill(BLOCKS["cases"])
    for law, run in stops.items():
        after = run["time"] > STOP_AT
        distance = run["position"][-1] - run["position"][after][0]
        safety = float(np.min(run["slip_safety"][after]))
        print(f"{law:<14} stops within {distance:.1f} m, smallest slip safety {safety:.2f}")


if __name__ == "__main__":
    main()
