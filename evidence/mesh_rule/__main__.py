"""Print the fitted laws of the mesh and the shares that the rule's constants take; ``--measure``: 8 minutes."""

import argparse

import numpy as np
from tqdm import tqdm

from evidence.mesh_rule import laws, statics, trips
from evidence.mesh_rule.rule import shares, slip
from evidence.mesh_rule.scenes import FIT, draw
from evidence.rendering import DOCS
from evidence.tables import read, write
from rope_model.method.mesh_fit import MAX_LENGTH

DATA = DOCS / "data" / "mesh_rule"
#: measured on so many ropes of the fitting seed
TABLES = {"loop": statics.loop, "cover": statics.cover, "ends": statics.ends, "parts": trips.parts}
ROPES = 16


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser("python -m evidence.mesh_rule", description=__doc__)
    parser.add_argument("--measure", action="store_true", help="measure the data anew")
    if parser.parse_args().measure:
        ropes = list(draw(FIT, ROPES))
        write(
            {name: measure(tqdm(ropes, name, leave=False)) for name, measure in TABLES.items()},
            DATA,
        )
    found = laws.fit(read(DATA))
    tables = read(DATA)
    for name, fit in found._asdict().items():
        values = ", ".join(f"{x:.3g}" for x in fit.values)
        print(
            f"{name:<13} {values:<20} factor left: {np.exp(fit.spread):.2f} (rms), {np.exp(fit.worst):.2f} (largest)"
        )
    print(
        "slip aside over height, elements up to {:.2f} w and longer: {:.2f}, {:.2f}".format(
            MAX_LENGTH, *slip(tables["loop"])
        )
    )
    for asked in (0.05, 5e-3, 1e-3, 2e-4):
        of = shares(found, asked)
        largest = f"loop {of.loop.max():.2f}, cover {of.cover.max():.2f}"
        print(
            f"asked {1e3 * asked:g} mm: of it at most {largest}; clamp moment off by {100 * of.moment.max():.2f} %"
        )


if __name__ == "__main__":
    main()
