"""What one length of the mesh does to a rope at rest, all its other lengths fine."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from evidence.mesh_rule.scenes import Sample
from evidence.tables import Array, Table, table
from rope_model import EndMotion
from rope_model.engine import NativeRope
from rope_model.method.mesh_fit import LEG_WAVES
from rope_model.method.partition import Partition
from rope_model.solver_parameters import Mesh

#: over (EI / rho g)^(1/3): loop elements tried, those of the reference, and those where something else is tried
LOOP_LENGTHS = (0.2, 0.28, 0.4, 0.5, 0.56, 0.62, 0.68, 0.74, 0.8, 0.9, 1.0)
FINEST = 0.05
FINE = 0.2
#: half of segment IV, in the same unit: what is tried, and what is enough
COVERS = (1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.2, 2.4, 2.6)
AMPLE = 3.5
COVER_LENGTHS = (0.2, 0.4, 0.6)
LEVELS = (0, 1, 2, 3, 4, 5)
MOST_LEVELS = 7
#: parts of l by which the loop hangs off the middle of its mesh
OFF_CENTRE = (-0.45, -0.2, 0.1, 0.35)
FAR_OFF = 0.45


@dataclass(frozen=True)
class RestShape:
    """A rope at rest: place of the loop's lowest point (x, y), m; clamp moment, N m, and pull, N, of the left end."""

    place: Array
    bottom: float  # m, arc length of it
    moment: float
    tension: float
    mesh: Partition

    @property
    def cover(self) -> float:
        """From the loop's lowest point to the nearer end of segment IV, m."""
        half = 0.5 * self.mesh.counts[3] * 0.25 * self.mesh.coarse
        return half - abs(self.bottom - self.mesh.centre)


def pattern(sample: Sample, fine: float, cover: float = AMPLE, levels: int = 4) -> Mesh:
    """Loop elements of ``fine`` and half a segment IV of at least ``cover``, both in (EI / rho g)^(1/3)."""
    coarse = 4 * fine * sample.w
    count = 4 * math.ceil(2 * cover * sample.w / coarse)
    growth = LEG_WAVES / sample.rope.length  # at rest the legs' elements change nothing
    return Mesh(
        "tmn",
        coarse_length=coarse,
        counts=(2, 0, count, 0, 2),
        end_levels=levels,
        grading_length=growth,
    )


def hang(sample: Sample, mesh: Mesh, height: float) -> RestShape:
    """The rope with its right end ``height`` (m) above the left."""
    for shift in range(8):
        rope = NativeRope(sample.scene(mesh))
        status = rope.initialize(0.0, EndMotion(), EndMotion(y=height + 1e-6 * shift))
        if status.valid:
            break
    else:  # short elements of a long rope: the last correction may be rounding, which another height rounds otherwise
        raise RuntimeError(status.message)
    x, y, moment, tension = rope.signals(("loop.x", "loop.y", "left.mz", "left.fy")).values()
    return RestShape(
        place=np.array([x, y]),
        bottom=rope.linear_facts().lowest_s,
        moment=moment,
        tension=abs(tension),
        mesh=rope.state.partition,
    )


def height(sample: Sample, mesh: Mesh, off: float) -> float:
    """Of the right end, m, with which the loop hangs ``off`` times l from the middle of its mesh, at 0.4 L."""
    coarse = mesh.coarse_length
    whole = round(0.4 * sample.rope.length / coarse)
    return sample.rope.length - 2 * coarse * (whole + off)


def shift(sample: Sample, mesh: Mesh, other: Mesh, off: float) -> Array:
    """Between the loop's places on two meshes, m."""
    at = height(sample, mesh, off)
    return hang(sample, mesh, at).place - hang(sample, other, at).place


def long_enough(samples: Iterable[Sample]) -> Iterator[Sample]:
    """Those on which the patterns above have room."""
    return (d for d in samples if d.rope.length > 45 * d.w)


def loop(samples: Iterable[Sample]) -> Table:
    """How far the loop hangs too low, on average, and how far aside at most, over the length of its elements."""
    rows = []
    for d in long_enough(samples):
        finest = pattern(d, FINEST)
        for length in LOOP_LENGTHS:
            found = np.array([shift(d, pattern(d, length), finest, off) for off in OFF_CENTRE])
            rows.append(
                (
                    *_rope(d),
                    length * d.w,
                    -float(found[:, 1].mean()),
                    float(np.abs(found[:, 0]).max()),
                )
            )
    return table((*ROPE, "fine [m]", "too low [m]", "aside [m]"), rows)


def cover(samples: Iterable[Sample]) -> Table:
    """How far the loop's place is off because fine elements end ``cover`` above its lowest point."""
    rows = []
    for d in long_enough(samples):
        for length in COVER_LENGTHS:
            ample = pattern(d, length)
            for wanted in COVERS:
                mesh = pattern(d, length, wanted)
                at = height(d, mesh, FAR_OFF)
                hung = hang(d, mesh, at)
                off = float(np.linalg.norm(hung.place - hang(d, ample, at).place))
                rows.append((*_rope(d), length * d.w, hung.cover, off))
    return table((*ROPE, "fine [m]", "cover [m]", "off [m]"), rows)


def ends(samples: Iterable[Sample]) -> Table:
    """Relative error of the clamp moment over the length of the element at the clamp and the bending layer's."""
    rows = []
    for d in long_enough(samples):
        exact = hang(d, pattern(d, FINE, levels=MOST_LEVELS), 0.0)
        for levels in LEVELS:
            mesh = pattern(d, FINE, levels=levels)
            hung = hang(d, mesh, 0.0)
            layer = math.sqrt(d.rope.EI / hung.tension)
            rows.append(
                (*_rope(d), float(hung.mesh.lengths[0]), layer, abs(hung.moment / exact.moment - 1))
            )
    return table((*ROPE, "end element [m]", "layer [m]", "moment error"), rows)


ROPE = ("scene", "length [m]", "mass [kg/m]", "EI [N m2]", "EA [N]", "spacing [m]", "w [m]")


def _rope(d: Sample) -> tuple[object, ...]:
    r = d.rope
    return d.number, r.length, r.mass_per_length, r.EI, r.Qa, d.layout.spacing, d.w
