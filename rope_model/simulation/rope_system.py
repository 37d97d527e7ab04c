"""The rope's equations of motion on one mesh: physics.element chained by numerics.block_chain.

A ``RopeSystem`` is immutable: mesh, material, frame pole and how the ends are held are fixed in it.  Anything that
changes makes a new one (cheap: the kernels are shared).
"""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..numerics.block_chain import ChainFunctions, chain_functions
from ..numerics.kernels import (
    LIBRARY_SUFFIX,
    Kernel,
    KernelForm,
    build_library,
    cache_folder,
    find_compiler,
    load_portable,
    platform_tag,
    prepare,
    save_portable,
)
from ..parameters import Rope
from ..physics.element import BALANCE, NODE_DOF, STRAINS, element_functions

Array = NDArray[np.float64]

#: places of r, r' and theta in a node's row
POSITION, SLOPE, ANGLE = slice(0, 3), slice(3, 6), 6


class RopeKernels:
    """The chain's functions for ``elements`` elements, ready to be called on arrays of shape (nodes, 7).

    ``bundle`` is a folder written by ``write_bundle``; without it, or without files for this size and platform in
    it, the functions are built from the element and compiled when that is possible.
    """

    def __init__(self, elements: int, form: KernelForm = "auto", bundle: Path | None = None) -> None:
        library, portable = _bundle_files(bundle, elements) if bundle else (None, None)
        if portable is not None and portable.exists():
            functions = load_portable(portable)
        else:
            functions = list(rope_functions(elements).all())
        (direction, assess, strains), self.form = prepare(functions, form, library)
        nodes = (elements + 1, NODE_DOF)
        self.elements = elements
        self.direction = Kernel(direction, (nodes, nodes))
        self.assess = Kernel(assess, (nodes, (len(BALANCE),)))
        self.strains = Kernel(strains, ((elements, len(STRAINS)),))


def write_bundle(elements: int, folder: Path) -> list[Path]:
    """Write the portable kernels and, with a compiler, those for this platform into ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    functions = rope_functions(elements).all()
    library, portable = _bundle_files(folder, elements)
    save_portable(functions, portable)
    written = [portable]
    if (compiler := find_compiler()) is not None:
        shutil.copyfile(build_library(functions, compiler, cache_folder()), library)
        written.append(library)
    return written


def _bundle_files(folder: Path, elements: int) -> tuple[Path, Path]:
    return folder / f"chain-{elements}-{platform_tag()}{LIBRARY_SUFFIX}", folder / f"chain-{elements}.casadi"


def rope_functions(elements: int) -> ChainFunctions:
    """CasADi functions of a rope of ``elements`` elements."""
    element = element_functions()
    return chain_functions(elements, element.residual, element.tangent, element.balance, element.strains)


def parameter_vector(rope: Rope, gravity: float, pole: Array) -> Array:
    """The element's parameters in the order of physics.element.PARAMETERS."""
    r = rope
    return np.array([r.mass_per_length, gravity, r.Qa, r.Qs, r.Qk, r.Qd, r.EI, r.rhoJ, r.beta_K, *pole])


def arc_lengths(lengths: Array) -> Array:
    """Arc length (m) of the nodes from the left end, for element lengths from left to right."""
    return np.concatenate(([0.0], np.cumsum(lengths)))


class Boundary(Protocol):
    """How the ends are held and loaded; arrays of shape (nodes, 7)."""

    def free(self, nodes: int) -> NDArray[np.bool_]:
        """True where a degree of freedom is free."""

    def prescribed(self, t: float, nodes: int) -> tuple[Array, Array, Array]:
        """q, v, a with the prescribed entries filled in."""

    def load(self, t: float, reaction: Array) -> Array:
        """Loads at the nodes."""


@dataclass(frozen=True)
class Assessment:
    """Residual (reactions where held) and the balance of physics.element by name, J and W."""

    reaction: Array
    balance: dict[str, float]


class RopeSystem:
    """Equations of motion for numerics.generalized_alpha and for statics."""

    def __init__(
        self, kernels: RopeKernels, lengths: Array, P: Array, boundary: Boundary, node_mass: Array | None = None
    ) -> None:
        nodes = lengths.size + 1
        self.kernels, self.lengths, self.P, self.boundary = kernels, lengths, P, boundary
        self.free = boundary.free(nodes)
        self.node_mass = np.zeros((nodes, NODE_DOF)) if node_mass is None else node_mass
        self._free = self.free.astype(float)
        self._scale = np.ones(NODE_DOF)
        self._scale[SLOPE] = lengths.min()

    def prescribed(self, t: float) -> tuple[Array, Array, Array]:
        return self.boundary.prescribed(t, self.lengths.size + 1)

    def direction(self, t: float, q: Array, v: Array, a: Array, reaction: Array, c: Array) -> tuple[Array, Array]:
        x, R = self.kernels.direction(
            q, v, a, self.lengths, self.boundary.load(t, reaction), self.node_mass, self._free, self.P, c
        )
        return x, R

    def assess(self, t: float, q: Array, v: Array, a: Array, reaction: Array) -> Assessment:
        """Residual and balance; the inertia of concentrated masses is added to the kinetic energy."""
        R, sums = self.kernels.assess(q, v, a, self.lengths, self.boundary.load(t, reaction), self.node_mass, self.P)
        balance = dict(zip(BALANCE, sums.tolist(), strict=True))
        balance["kinetic"] += 0.5 * float(np.sum(self.node_mass * v * v))
        return Assessment(R, balance)

    def strains(self, q: Array) -> Array:
        """(elements, 4), columns as in physics.element.STRAINS."""
        return self.kernels.strains(q, self.lengths, self.P)[0]

    def norm(self, x: Array) -> float:
        return float(np.max(np.abs(x) * self._scale))
