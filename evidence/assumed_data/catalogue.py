"""The tables of docs/howto/rope_data.md, from the catalogue itself."""

from evidence.rendering import markdown, number
from rope_model import BEARINGS, CONSTRUCTIONS, Datum
from rope_model.catalogue import PROPERTIES


def catalogue() -> str:
    """Return the ranges of ropes and bearings."""
    ropes = []
    for name, construction in CONSTRUCTIONS.items():
        factors = construction.factors()
        ropes.append(
            (f"`{name}`", construction.description, *(_range(factors[key]) for key in PROPERTIES))
        )
    head = [f"{name} / d^{kind.power}" if kind.power else name for name, kind in PROPERTIES.items()]
    bearings = [
        (f"`{name}`", *(_range(datum) for datum in data.values()))
        for name, data in BEARINGS.items()
    ]
    return "\n\n".join(
        (
            markdown(ropes, "construction", "", *(text.replace("_", " ") for text in head)),
            markdown(
                bearings, "bearing of the swivel", "running friction", "starting over running"
            ),
        )
    )


def _range(datum: Datum) -> str:
    return f"{number(datum.low)} to {number(datum.high)}"
