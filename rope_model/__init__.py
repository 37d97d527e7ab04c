"""Balance rope of a friction hoist: coupled tension, torsion and lateral motion of a round wire rope.

Conventions, everywhere in this package
---------------------------------------
Units are SI; the unit stands on every field that is not obvious.  X is horizontal in the plane of the hanging loop
(from the left suspension point to the right one), Y is up, Z = X x Y is horizontal out of plane.  Arc length s runs
from the left end to the right end, so the tangent is -Y at the left end and +Y at the right end.  Twist, torque and
theta are positive about the tangent.  The conveyance's yaw and the loop's yaw are positive about Y.  Signals fx
... mz are forces and moments of the rope on the conveyance.

A user imports from this package, as in ``from rope_model import EndMotion, balance_rope,
rope_120``; rope_model.public lists the names.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from rope_model.version import __version__ as __version__

if TYPE_CHECKING:
    from rope_model.public import *  # noqa: F403
else:

    def __getattr__(name):
        # not before it is asked for: the parameters alone need no CasADi, and the Python FMU has no
        # native form
        if name == "__all__" or not name.startswith("_"):
            try:
                public = import_module(".public", __name__)
            except AttributeError as error:  # or Python would say that this package lacks the name
                raise ImportError(f"{__name__}.public cannot be imported: {error}") from error
            if name == "__all__" or name in public.__all__:
                return getattr(public, name)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def __dir__():
        return [*globals(), *import_module(".public", __name__).__all__]
