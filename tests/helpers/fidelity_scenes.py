"""A rope that each model of it can follow, or not."""

from scenes import fixed_steps, smooth_step

from rope_model import Mesh, Rope, Scene
from rope_model.boundary.end_paths import EndMotion

Ends = tuple[EndMotion, EndMotion]

UNCOUPLED = Rope(length=30.0, Qb=0.0, Qc=0.0)

#: 30 m rope on TMN-ETM, for transformations, and on equal elements; in steps as long as the host's
SHORT = Scene(
    rope=UNCOUPLED, mesh=Mesh(coarse_length=1.6, counts=(2, 4, 40, 4, 2)), solver=fixed_steps(0.04)
)

EVEN = SHORT.with_(mesh=Mesh(kind="eem", elements=62))

HIGH = 12.0
TRAVEL = 8.0
DURATION = 5.0


def ends_at(t: float, z: float = 0.0, yaw: float = 0.0, duration: float = DURATION) -> Ends:
    """A smooth trip from rest; between 1 s and 4 s the left conveyance moves out of plane and turns."""
    x, v, a = (TRAVEL * value for value in smooth_step(t, 0.0, duration))
    beside = smooth_step(t)
    z, vz, az = (z * value for value in beside)
    left = EndMotion(
        y=x, vy=v, ay=a, z=z, vz=vz, az=az, yaw=yaw * beside[0], yaw_rate=yaw * beside[1]
    )
    return left, EndMotion(y=HIGH - x, vy=-v, ay=-a)
