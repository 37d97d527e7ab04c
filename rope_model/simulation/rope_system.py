"""The rope's equations of motion on one mesh: physics.element chained by numerics.block_chain.

A ``RopeSystem`` is immutable: mesh, material, the frame's reference and how the ends are held are fixed in it.
Anything that changes makes a new one (cheap: the kernels are shared).
"""

from __future__ import annotations

import copy
import logging
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..numerics.block_chain import ChainFunctions, ChainParts, chain_functions, chain_parts
from ..numerics.generalized_alpha import Solution
from ..numerics.kernels import (
    LIBRARY_SUFFIX,
    Kernel,
    KernelForm,
    build_library,
    build_parts,
    cache_folder,
    find_compiler,
    load_compiled,
    load_portable,
    platform_tag,
    prepare,
    save_portable,
)
from ..numerics.newton import PROGRESS, report
from ..parameters import Rope
from ..physics.element import BALANCE, ELEMENT_DOF, MOMENTUM, NODE_DOF, STRAINS, ElementFidelity, element_functions

Array = NDArray[np.float64]
log = logging.getLogger(__name__)

#: places of r, r' and theta in a node's row
POSITION, SLOPE, ANGLE = slice(0, 3), slice(3, 6), 6


class RopeKernels:
    """The chain's functions for ``elements`` elements on one fidelity, to be called on arrays of shape (nodes, 7).

    What a fidelity leaves out stays zero.  ``bundle`` is a folder written by ``write_bundle``; without it, or without
    files for this size, fidelity and platform in it, the functions are built from the element and compiled when that is
    possible.
    """

    def __init__(
        self,
        elements: int,
        form: KernelForm = "auto",
        bundle: Path | None = None,
        fidelity: ElementFidelity = "torsional",
    ) -> None:
        library, portable = _bundle_files(bundle, elements, fidelity) if bundle else (None, None)
        if portable is not None and portable.exists():
            functions = load_portable(portable)
        else:
            functions = list(rope_functions(elements, fidelity).all())
        (solve, newton_step, evaluate, losses, strains, momentum, reference, transport), self.form = prepare(
            functions, partial(_build, elements, fidelity), form, library
        )
        nodes, balance = (elements + 1, NODE_DOF), (len(BALANCE),)
        self.elements, self.fidelity = elements, fidelity
        self.solve = Kernel(solve, (nodes, nodes, nodes, nodes, balance, (len(PROGRESS),)))
        self.newton_step = Kernel(newton_step, (nodes, nodes))
        self.evaluate = Kernel(evaluate, (nodes, balance))
        self.losses = Kernel(losses, ((2,),))
        self.strains = Kernel(strains, ((elements, len(STRAINS)),))
        self.momentum = Kernel(momentum, ((len(MOMENTUM),),))
        self.reference = Kernel(reference, ((elements, reference.size1_out(0)),))
        self.transport = Kernel(transport, ((elements, 3),))


class KernelCache:
    """The kernels of every fidelity for one number of elements, made when first needed."""

    def __init__(self, elements: int, form: KernelForm = "auto", bundle: Path | None = None) -> None:
        self.elements, self._form, self._bundle = elements, form, bundle
        self._made: dict[ElementFidelity, RopeKernels] = {}

    def of(self, fidelity: ElementFidelity) -> RopeKernels:
        """Those of ``fidelity``."""
        if fidelity not in self._made:
            self._made[fidelity] = RopeKernels(self.elements, self._form, self._bundle, fidelity)
        return self._made[fidelity]


def write_bundle(elements: int, folder: Path) -> list[Path]:
    """Write the portable kernels and, with a compiler, those for this platform into ``folder``, for every fidelity."""
    folder.mkdir(parents=True, exist_ok=True)
    written, compiler = [], find_compiler()
    if compiler is None:
        log.warning(
            "no compiled kernels go into %s, for want of a C compiler: CasADi's virtual machine takes several times as "
            "long; install a compiler, or pip install 'balance-rope[compiler]'",
            folder.name,
        )
    for fidelity in ELEMENT_DOF:
        library, portable = _bundle_files(folder, elements, fidelity)
        save_portable(rope_functions(elements, fidelity).all(), portable)
        written.append(portable)
        if compiler is not None:
            shutil.copyfile(_build(elements, fidelity, compiler), library)
            written.append(library)
    return written


def _build(elements: int, fidelity: ElementFidelity, compiler: Sequence[str]) -> Path:
    """The compiled library: the element is the same in ropes of any number of elements, and compiled once."""
    parts = build_parts(rope_parts(fidelity), compiler, cache_folder(), f"element-{fidelity}")
    functions = _linked_functions(elements, fidelity, parts.library).all()
    return build_library(functions, compiler, cache_folder(), f"kernels-{fidelity}-{elements}", [parts.linked])


@cache
def _linked_functions(elements: int, fidelity: ElementFidelity, library: Path) -> ChainFunctions:
    """Those of ``rope_functions``, but calling what ropes of any size have in common."""
    parts = ChainParts(*load_compiled(rope_parts(fidelity), library))
    return chain_functions(elements, parts, NODE_DOF, ELEMENT_DOF[fidelity])


def _bundle_files(folder: Path, elements: int, fidelity: ElementFidelity) -> tuple[Path, Path]:
    name = f"{fidelity}-{elements}"
    return folder / f"{name}-{platform_tag()}{LIBRARY_SUFFIX}", folder / f"{name}.casadi"


@cache
def rope_parts(fidelity: ElementFidelity) -> ChainParts:
    """CasADi functions that ropes of any number of elements have in common."""
    return chain_parts(element_functions(fidelity))


@cache
def rope_functions(elements: int, fidelity: ElementFidelity = "torsional") -> ChainFunctions:
    """CasADi functions of a rope of ``elements`` elements."""
    return chain_functions(elements, rope_parts(fidelity), NODE_DOF, ELEMENT_DOF[fidelity])


def parameter_vector(rope: Rope, gravity: float) -> Array:
    """The element's parameters in the order of physics.element.PARAMETERS."""
    r = rope
    return np.array([r.mass_per_length, gravity, r.Qa, r.Qs, r.Qk, r.Qd, r.EI, r.rhoJ, r.beta_K])


def arc_lengths(lengths: Array) -> Array:
    """Arc length (m) of the nodes from the left end, for element lengths from left to right."""
    return np.concatenate(([0.0], np.cumsum(lengths)))


class Boundary(Protocol):
    """How the ends are held and loaded; arrays of shape (nodes, 7)."""

    def free(self, nodes: int) -> NDArray[np.bool_]:
        """True where a degree of freedom is free."""

    def prescribed_motion(self, t: float, nodes: int) -> Array:
        """(3, nodes, 7): q, v, a with the prescribed entries filled in."""

    def load(self, nodes: int) -> Array:
        """Dead loads at the nodes."""

    def friction_load(self, nodes: int) -> Array:
        """Loads per newton of the node's own vertical reaction, where that pulls upwards: friction."""


@dataclass(frozen=True)
class Evaluation:
    """Residual (reactions where held) and the balance of physics.element by name, J and W."""

    reaction: Array
    balance: dict[str, float]


class RopeSystem:
    """Equations of motion for numerics.generalized_alpha and for statics.

    ``reference`` (nodes, 7) is the state from which the frame is counted; see physics.frame.
    """

    def __init__(
        self,
        kernels: RopeKernels,
        lengths: Array,
        P: Array,
        boundary: Boundary,
        reference: Array,
        node_mass: Array | None = None,
    ) -> None:
        nodes = lengths.size + 1
        self.kernels, self.lengths, self.P, self.boundary = kernels, lengths, P, boundary
        self.reference = reference
        self.free = boundary.free(nodes)
        self.load = boundary.load(nodes)
        self.node_mass = np.zeros((nodes, NODE_DOF)) if node_mass is None else node_mass
        self._free = self.free.astype(float)
        self._scale = np.ones(NODE_DOF)
        self._scale[SLOPE] = lengths.min()
        self._loads = self.load, boundary.friction_load(nodes), self.node_mass
        self._refer()

    def _refer(self) -> None:
        self.frames = self.kernels.reference(self.reference, self.lengths)[0]
        self._constants = self.lengths, self.frames, *self._loads

    def with_boundary(self, boundary: Boundary) -> RopeSystem:
        """The same system with the ends held in the same way but moved otherwise."""
        other = copy.copy(self)
        other.boundary = boundary
        return other

    def with_reference(self, q: Array) -> RopeSystem:
        """The same system with the frame counted from ``q``."""
        if q is self.reference:
            return self
        other = copy.copy(self)
        other.reference = q
        other._refer()
        return other

    def transport(self, q: Array, v: Array, a: Array) -> Array:
        """(3, nodes): what theta, theta_t and theta_tt gain when ``q`` becomes the reference.

        The frame of the left end stays, and the sections stay where they are.
        """
        gained = np.zeros((3, q.shape[0]))
        gained[:, 1:] = self.kernels.transport(q, v, a, self.lengths, self.frames)[0].T
        gained[0] = np.cumsum(gained[0])
        return gained

    def frame_turn(self, q: Array) -> Array:
        """(nodes,): what theta gains when ``q`` becomes the reference, rad."""
        rest = np.zeros_like(q)
        turn: Array = self.transport(q, rest, rest)[0]
        return turn

    def prescribed_motion(self, t: float) -> Array:
        return self.boundary.prescribed_motion(t, self.lengths.size + 1)

    def solve(self, q: Array, v: Array, a: Array, reaction: Array, c: Array, tolerance: float) -> Solution[Evaluation]:
        q, v, a, R, sums, progress = self.kernels.solve(
            q, v, a, reaction, *self._constants, self._free, self.P, c, self._scale, tolerance
        )
        return Solution(q, v, a, self._evaluation(v, R, sums), report(progress.tolist()))

    def newton_step(self, q: Array, v: Array, a: Array, reaction: Array, c: Array) -> tuple[Array, Array]:
        x, R = self.kernels.newton_step(q, v, a, reaction, *self._constants, self._free, self.P, c)
        return x, R

    def evaluate(self, q: Array, v: Array, a: Array, reaction: Array) -> Evaluation:
        """Residual and balance; the inertia of concentrated masses is added to the kinetic energy."""
        R, sums = self.kernels.evaluate(q, v, a, reaction, *self._constants, self.P)
        return self._evaluation(v, R, sums)

    def _evaluation(self, v: Array, R: Array, sums: Array) -> Evaluation:
        balance = dict(zip(BALANCE, sums.tolist(), strict=True))
        balance["kinetic"] += 0.5 * float(np.vdot(self.node_mass, v * v))
        return Evaluation(R, balance)

    def losses(self, q: Array, v: Array) -> tuple[float, float]:
        """Damping power and the power of the non-conservative coupling, W."""
        damping, nonconservative = self.kernels.losses(q, v, self.lengths, self.frames, self.P)[0].tolist()
        return damping, nonconservative

    def strains(self, q: Array) -> Array:
        """(elements, 3), columns as in physics.element.STRAINS."""
        return self.kernels.strains(q, self.lengths, self.frames)[0]

    def momentum(self, q: Array, v: Array) -> Any:
        """(9,) numbers as in physics.element.MOMENTUM, ``q`` the reference; with the concentrated masses' spin."""
        sums = self.kernels.momentum(q, v, self.lengths, self.P)[0]
        sums[3:6] += (self.node_mass[:, ANGLE] * v[:, ANGLE]) @ q[:, SLOPE]
        return tuple(sums.tolist())

    def norm(self, x: Array) -> float:
        return float((np.abs(x) * self._scale).max())
