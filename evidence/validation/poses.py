"""Wires of 0.4 m, held straight, of which a robot moves, tilts and then turns one end: shapes at rest.

Measured: points of three wires in four poses, in pixels and depth (mm) of a camera; github.com/qj25/adapteddlo_muj
(Chen, Bretl, Pham, arXiv:2310.00911), adapteddlo_muj/data/data3d, commit 6ed3708; here in ``measured_poses``, with its
MIT licence.  Poses are those of scripts/test_shape_w_arm.py, as we read it; rays of the camera are those of
utils/finddepth.py.

The camera's place and scale are not published.  As the authors do, the points are scaled to the wire's length, laid
with their first on the fixed end, and turned by the smallest rotation until the last lies in the direction of the
robot's.  Stiffnesses are those of wires.py.
"""

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from evidence.statics import held, rod
from evidence.tables import Array, Table, read, rows, table
from evidence.validation.wires import GRAVITY, WIRES, Wire
from rope_model.physics.node import ANGLE, POSITION, SLOPE
from rope_model.reference.statics import find_equilibrium

LENGTH = 0.4  # m
ELEMENTS = 60  # m
#: steps of the way to the pose, and of a turn of 360 deg
MOVES = 20
TURNS = 36
#: points of the wire that are compared, the fixed end included
POINTS = 11
#: of the camera: pixels, and deg
PIXELS = np.array([640.0, 576.0])
VIEW = np.array([75.0, 65.0])
#: from the axes of the authors' world, the third up, to ours, the second up
OURS = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
#: of the robot's hand: its third axis lies along the straight wire
HAND = Rotation.from_euler("y", 90.0, degrees=True)


@dataclass(frozen=True)
class Pose:
    """Where the robot takes the end: way (m) in the world, tilt (deg; rotation vector of the hand), turn (deg)."""

    way: tuple[float, float, float]
    tilt: tuple[float, float, float]
    turn: float


POSES = (
    Pose((0.165, -0.1, -0.15), (30.0, -40.0, 0.0), 360.0),
    Pose((0.06, 0.0, 0.0), (0.0, 0.0, 0.0), -720.0),
    Pose((0.165, 0.1, 0.1), (50.0, 10.0, 0.0), 360.0),
    Pose((0.165, 0.1, 0.1), (50.0, 20.0, -10.0), -720.0),
)


def shape(wire: Wire, EI: float, GJ: float, pose: Pose) -> Array:
    """(nodes, 3), m, from the robot's end to the fixed one."""
    s = np.linspace(0.0, 1.0, ELEMENTS + 1)
    q = np.zeros((s.size, 7))
    q[:, 0] = LENGTH * s
    q[:, SLOPE] = (1.0, 0.0, 0.0)
    equations = rod(wire.rope(LENGTH, EI, GJ), GRAVITY, q, held(q, [0, -1]))
    for part in np.arange(1, MOVES + 1) / MOVES:
        hand = HAND * Rotation.from_rotvec(part * np.array(pose.tilt), degrees=True)
        q[0, POSITION] = OURS @ (part * np.array(pose.way))
        q[0, SLOPE] = OURS @ hand.apply((0.0, 0.0, 1.0))
        if part == 1 / MOVES:  # a straight wire in compression is at rest too: it sags
            q[1:-1, 1] -= 0.01 * np.sin(np.pi * s[1:-1])
        q = find_equilibrium(equations.held_at(q), q).q
    for _ in range(round(abs(pose.turn) / 360.0 * TURNS)):
        q[:, ANGLE] += math.copysign(2.0 * math.pi / TURNS, pose.turn) * s
        q = find_equilibrium(equations.held_at(q), q).q
    return np.asarray(q[:, POSITION])


@cache
def _seen() -> Table:
    return read(Path(__file__).with_name("measured_poses"))["poses"]


def measured(wire: str, pose: int) -> Array:
    """(POINTS, 3), m, at equal lengths from the fixed end, scaled to the wire's length; axes of the camera."""
    seen = rows(_seen(), wire=wire, pose=pose)
    pixels = np.column_stack((seen["x"], seen["y"]))
    rays = np.tan((2.0 * pixels / PIXELS - 1.0) * np.radians(VIEW) / 2.0)
    x = seen["depth"][:, None] * np.column_stack((rays[:, 0], np.ones(len(rays)), -rays[:, 1]))
    points = _at_equal_lengths(x)
    return points * LENGTH / float(np.linalg.norm(np.diff(x, axis=0), axis=1).sum())


def _at_equal_lengths(x: Array) -> Array:
    lengths = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(x, axis=0), axis=1))))
    places = np.linspace(0.0, lengths[-1], POINTS)
    return np.column_stack([np.interp(places, lengths, axis) for axis in x.T])


def apart(wire: Wire, EI: float, GJ: float, pose: int) -> float:
    """RMS distance (m) of the measured points from ours."""
    # the camera looks against the first and second axis of the world
    ours = _at_equal_lengths(shape(wire, EI, GJ, POSES[pose])[::-1]) @ OURS * (-1.0, -1.0, 1.0)
    theirs = measured(wire.name, pose)
    ours = ours - ours[0]
    theirs = theirs - theirs[0]
    a, b = (x[-1] / np.linalg.norm(x[-1]) for x in (theirs, ours))
    axis = np.cross(a, b)
    size = float(np.linalg.norm(axis))
    turned = Rotation.from_rotvec(axis / size * math.atan2(size, float(a @ b))).apply(theirs)
    return float(np.sqrt(np.mean(np.sum((turned - ours) ** 2, axis=1))))


def measure() -> Table:
    """How far each wire in each pose is from ours with each pair of stiffnesses (mm)."""
    cases = [
        (w, EI, GJ, pose) for w in WIRES for EI, GJ in w.stiffness for pose in range(len(POSES))
    ]
    found = [(w.name, pose + 1, EI, GJ, 1e3 * apart(w, EI, GJ, pose)) for w, EI, GJ, pose in cases]
    return table(("wire", "pose", "EI", "GJ", "apart"), found)
