"""The rope in Exudyn: elements in a row, the ends prescribed by coordinate constraints.

The material is ours: strain |r'| - 1 with Qa, curvature per reference length with EI, and damping beta_K times the
same stiffnesses.  The ends move along an S-curve written as a sum of truncated cubics; Exudyn evaluates it itself
(a symbolic user function), so that no Python code runs inside its time steps.

No other module knows Exudyn.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

import exudyn as exu
import numpy as np
from exudyn import itemInterface as items
from exudyn.advancedUtilities import CreateSymbolicUserFunction

from evidence.tables import Array
from hoist_demo.control.trajectory import Trajectory
from rope_model.parameters import Rope, Scene
from rope_model.physics.hermite import node_values
from rope_model.physics.node import arc_lengths
from rope_model.reference.transfer import elements_at

CABLE_NODE = "NodePoint2DSlope1"
BEAM_NODE = "NodeRigidBody2D"
CABLE = "ObjectANCFCable2D"
BEAM = "ObjectBeamGeometricallyExact2D"
#: prescribed coordinates of an end node
HELD = (0, 1, 2)
#: N, of the elements with shear; 1e5 to 1.2e8 N move the loop by less than 0.6 mm.
SHEAR_STIFFNESS = 1e6


@dataclass(frozen=True)
class Element:
    """One of Exudyn's elements, three coordinates of an end node of which are prescribed; ``options`` are its own."""

    label: str
    item: str
    node: str
    middle: bool = False  # has a node in its middle
    options: dict[str, Any] = field(default_factory=dict)

    def coordinates(self, q: Array) -> Array:
        """Return its nodes' coordinates for ours, (nodes, 7), in the plane."""
        if self.node == CABLE_NODE:
            return q[:, [0, 1, 3, 4]]
        return np.column_stack((q[:, :2], np.unwrap(np.arctan2(q[:, 4], q[:, 3]))))

    def ours(self, c: Array) -> Array:
        """Return (nodes, 7): r, r' and a zero angle for its nodes' coordinates."""
        q = np.zeros((c.shape[0], 7))
        if self.node == CABLE_NODE:
            q[:, [0, 1, 3, 4]] = c
        else:
            q[:, [0, 1]] = c[:, :2]
            q[:, 3] = np.cos(c[:, 2])
            q[:, 4] = np.sin(c[:, 2])
        return q


ELEMENTS = {
    "ancf": Element(
        "ANCFCable2D, Gauss", CABLE, CABLE_NODE, options={"useReducedOrderIntegration": 1}
    ),
    "ancf-lobatto": Element(
        "ANCFCable2D, Lobatto", CABLE, CABLE_NODE, options={"useReducedOrderIntegration": 2}
    ),
    "beam": Element("BeamGeometricallyExact2D, linear", BEAM, BEAM_NODE),
    "beam-quadratic": Element("BeamGeometricallyExact2D, quadratic", BEAM, BEAM_NODE, middle=True),
}


@dataclass(frozen=True)
class Method:
    """Generalized-alpha in Exudyn."""

    step: float  # s
    newton: Literal["full", "modified"] = "modified"
    spectral_radius: float = 0.8
    tolerance: float = 1e-5  # of the residual, relative to the first one of a step


@dataclass(frozen=True)
class Record:
    """Samples of a run: vertical end forces (n, 2), N, and nodes as (n, nodes, 7)."""

    force: Array
    q: Array
    cpu: float  # s, of the time steps alone


class PeerError(RuntimeError):
    """Exudyn gives up."""


class PeerRope:
    """``count`` elements between two vertical ends, at first where ``q`` (nodes, 7) at arc lengths ``s`` hangs.

    ``heights`` are those of the ends, m; ``reference`` moves the left end up by it and the right end down.
    """

    def __init__(
        self,
        scene: Scene,
        element: str,
        count: int,
        hanging: tuple[Array, Array],
        heights: tuple[float, float],
        reference: Trajectory | None = None,
    ) -> None:
        self.element = ELEMENTS[element]
        self.rope = scene.rope
        pieces = 2 * count if self.element.middle else count
        self.lengths = np.full(pieces, self.rope.length / pieces)
        s, q = hanging
        self._start = _nodes_at(q, s, arc_lengths(self.lengths))
        self._half = 0.5 * scene.layout.spacing
        self._heights = heights
        self._container = exu.SystemContainer()
        self.mbs = self._container.AddSystem()
        self._add_elements(count, scene.layout.gravity)
        self._constraints = self._add_ends()
        self._functions: list[Any] = []
        if reference is not None:
            for node, sense in ((0, 1.0), (1, -1.0)):
                self._prescribe(self._constraints[node][1], *s_curve(reference, sense))
        self._samples: list[tuple[float, Array, tuple[float, float]]] = []
        self._sampling = 0.0
        sensor = items.SensorUserFunction(
            sensorNumbers=[], writeToFile=False, sensorUserFunction=self._sample
        )
        self.mbs.AddSensor(sensor)
        self.mbs.Assemble()

    def rest(self) -> None:
        """Find the equilibrium near the present shape, and start from it."""
        settings = _settings()
        static = settings.staticSolver
        static.numberOfLoadSteps = 1
        static.adaptiveStep = False
        static.newton.maxIterations = 300
        static.loadStepDuration, static.useLoadFactor = (
            1e-9,
            False,
        )  # the ends' motions are functions of its time
        static.newton.relativeTolerance = 1e-7
        static.newton.absoluteTolerance = 1e-6
        try:
            self.mbs.SolveStatic(settings, updateInitialValues=True)
        except (exu.ExudynError, ValueError) as error:
            raise PeerError(
                f"{self.element.label}: no equilibrium with {self.lengths.size} elements"
            ) from error

    def run(self, duration: float, sample: float, method: Method) -> Record:
        """Follow the ends' motion, with a record every ``sample`` seconds."""
        settings = _settings()
        time_integration = settings.timeIntegration
        time_integration.endTime = duration
        time_integration.numberOfSteps = round(duration / method.step)
        time_integration.newton.relativeTolerance = method.tolerance
        time_integration.newton.useModifiedNewton = method.newton == "modified"
        time_integration.generalizedAlpha.spectralRadius = method.spectral_radius
        # a run starts from rest
        time_integration.generalizedAlpha.computeInitialAccelerations = False
        settings.solution.sensors.active = True
        settings.solution.sensors.writePeriod = sample
        self._samples.clear()
        self._sampling = 0.0
        start = time.process_time()
        try:
            self.mbs.SolveDynamic(settings)
        except (exu.ExudynError, ValueError) as error:
            raise PeerError(
                f"{self.element.label}: fails at {self._samples[-1][0]:.2f} s"
            ) from error
        cpu = time.process_time() - start - self._sampling
        # the start is recorded too, twice
        wanted: Array = sample * np.arange(1.0, round(duration / sample) + 1)
        times = np.array([t for t, _, _ in self._samples])
        rows = [int(np.argmin(np.abs(times - t))) for t in wanted]
        return Record(
            force=-np.array(
                [self._samples[k][2] for k in rows]
            ),  # its multipliers change sign with the solver
            q=np.array([self._ours(self._samples[k][1]) for k in rows]),
            cpu=cpu,
        )

    def end_forces(self) -> tuple[float, float]:
        """Vertical forces on the ends, N, up."""
        left, right = (
            self.mbs.GetObjectOutput(c[1], exu.OutputVariableType.Force) for c in self._constraints
        )
        return -float(left), -float(right)

    def frequencies(self, count: int) -> Array:
        """Return the lowest natural frequencies (count,), Hz, about the equilibrium."""
        last = self._reference.size - self._reference.shape[1]
        options: dict[str, Any] = {"numberOfEigenvalues": count, "ignoreAlgebraicEquations": True}
        options["constrainedCoordinates"] = [j + k for k in (0, last) for j in HELD]
        values, _ = self.mbs.ComputeODE2Eigenvalues(**options)
        return np.asarray(np.sqrt(np.maximum(values, 0.0)) / (2 * np.pi))

    # how it is built

    def _add_elements(self, count: int, gravity: float) -> None:
        element = self.element
        rope = self.rope
        straight = np.zeros_like(self._start)
        straight[:, 0] = -self._half
        straight[:, 4] = -1.0
        straight[1:, 1] = -np.cumsum(self.lengths)
        self._reference = self.element.coordinates(straight)
        displaced = self.element.coordinates(self._start) - self._reference
        node = getattr(items, element.node)
        self._nodes = [
            self.mbs.AddNode(node(referenceCoordinates=r, initialCoordinates=u))
            for r, u in zip(self._reference.tolist(), displaced.tolist(), strict=True)
        ]
        make = getattr(items, element.item)
        stride = 1 + element.middle
        data = {"length": rope.length / count} | self._section(rope) | element.options
        for k in range(count):
            body = self.mbs.AddObject(
                make(nodeNumbers=self._nodes[stride * k : stride * (k + 1) + 1], **data)
            )
            marker = self.mbs.AddMarker(items.MarkerBodyMass(bodyNumber=body))
            self.mbs.AddLoad(
                items.LoadMassProportional(markerNumber=marker, loadVector=[0.0, -gravity, 0.0])
            )

    def _section(self, rope: Rope) -> dict[str, Any]:
        GA = SHEAR_STIFFNESS
        beta = rope.beta_K
        data = {
            "massPerLength": rope.mass_per_length,
            "bendingStiffness": rope.EI,
            "axialStiffness": rope.Qa,
            "bendingDamping": beta * rope.EI,
            "axialDamping": beta * rope.Qa,
        }
        if self.element.item == BEAM:
            data |= {
                "crossSectionInertia": 0.5 * rope.rhoJ,
                "shearStiffness": GA,
                "shearDamping": beta * GA,
            }
        return data

    def _add_ends(self) -> list[list[Any]]:
        ground = self.mbs.AddNode(items.NodePointGround())
        zero = self.mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
        targets = self._start[[0, -1]].copy()
        for k, side in enumerate((-1.0, 1.0)):
            targets[k, :3] = side * self._half, self._heights[k], 0.0
            targets[k, 3:6] = 0.0, side, 0.0
        at = self.element.coordinates(targets)
        constraints = []
        for k, end in ((0, 0), (1, -1)):
            held = []
            for j in HELD:
                marker = self.mbs.AddMarker(
                    items.MarkerNodeCoordinate(nodeNumber=self._nodes[end], coordinate=j)
                )
                offset = float(at[k, j] - self._reference[end, j])
                connector = items.ObjectConnectorCoordinate(
                    markerNumbers=[zero, marker], offset=offset
                )
                held.append(self.mbs.AddObject(connector))
            constraints.append(held)
        return constraints

    def _prescribe(
        self, constraint: Any, offset: Callable[..., Any], rate: Callable[..., Any]
    ) -> None:
        for name, function in (("offsetUserFunction", offset), ("offsetUserFunction_t", rate)):
            made = CreateSymbolicUserFunction(
                self.mbs, function, name, itemTypeName="ObjectConnectorCoordinate"
            )
            self._functions.append(made)  # Exudyn keeps no reference
            self.mbs.SetObjectParameter(constraint, name, made)

    def _ours(self, displaced: Array) -> Array:
        return self.element.ours(self._reference + displaced.reshape(self._reference.shape))

    def _sample(
        self, mbs: Any, t: float, sensors: Any, factors: Any, configuration: Any
    ) -> list[float]:
        start = time.process_time()
        self._samples.append((t, np.array(mbs.systemData.GetODE2Coordinates()), self.end_forces()))
        self._sampling += time.process_time() - start
        return [0.0]


def _nodes_at(q: Array, s: Array, at: Array) -> Array:
    """Return nodes (points, 7) at arc lengths ``at`` of the rope ``q`` with nodes at ``s``."""
    element = elements_at(s, at)
    l = s[element + 1] - s[element]
    both = (*q[element].T, *q[element + 1].T)
    return np.stack(node_values((at - s[element]) / l, l, both), axis=-1)


def s_curve(reference: Trajectory, sense: float) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Return offset and rate as Exudyn's user functions: each change of the jerk adds a truncated cubic."""
    jerks = np.array([p.jerk for p in reference.points])
    terms = [
        (float(t), sense * float(j))
        for t, j in zip(reference.starts, np.diff(jerks, prepend=0.0), strict=True)
    ]

    def offset(mbs: Any, t: Any, item: Any, start: Any) -> Any:
        y = start
        for begin, jerk in terms:
            since = exu.symbolic.max(t - begin, 0.0)
            y = y + jerk / 6 * since * since * since
        return y

    def rate(mbs: Any, t: Any, item: Any, start: Any) -> Any:
        v = 0.0 * t
        for begin, jerk in terms:
            since = exu.symbolic.max(t - begin, 0.0)
            v = v + jerk / 2 * since * since
        return v

    return offset, rate


def _settings() -> Any:
    settings = exu.SimulationSettings()
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    settings.linearSolver.reuseAnalyzedPattern = True
    settings.solution.file.write = False
    settings.solution.sensors.active = False
    settings.timeIntegration.verboseMode = settings.staticSolver.verboseMode = 0
    settings.parallel.numberOfThreads = 1
    return settings
