"""The schemes by name, for whoever chooses one in a file or on a command line."""

from hoist_demo.cosimulation.schemes.energy import EnergyControlled
from hoist_demo.cosimulation.schemes.explicit import (
    GaussSeidel,
    ImpulsePreserving,
    Jacobi,
    SemiImplicit,
)
from hoist_demo.cosimulation.schemes.interface import Scheme
from hoist_demo.cosimulation.schemes.iterative import ACCELERATORS, Iterative

#: Numbers are orders of extrapolation; docs/howto/hoist.md compares them.
SCHEMES: dict[str, Scheme] = {
    **{f"jacobi-{order}": Jacobi(order) for order in range(3)},
    **{f"gauss-seidel-{order}": GaussSeidel(order) for order in range(3)},
    "impulse-preserving": ImpulsePreserving(),
    **{f"semi-implicit-{order}": SemiImplicit(order) for order in range(3)},
    **{f"iterative-{name}": Iterative(name) for name in ACCELERATORS},
    "implicit-impulse": Iterative("jacobian", hold_mean=True),
    "energy-controlled": EnergyControlled(GaussSeidel(1)),
}


def find_scheme(name: str) -> Scheme:
    """Return the scheme of this name; a ValueError lists all names."""
    if name not in SCHEMES:
        raise ValueError(f"scheme = '{name}' must be one of {', '.join(SCHEMES)}: choose one")
    return SCHEMES[name]
