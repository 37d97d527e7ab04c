"""Kernels of a rope: the functions of a chain of its elements, built, compiled, cached and bundled.

They depend on the number of elements, the fidelity and the features of the rope (``Features``), not on its data.
"""

import logging
import shutil
from collections.abc import Iterable, Sequence
from functools import cache, partial
from pathlib import Path

from rope_model import compiler as compiling
from rope_model.numerics.block_chain import ChainFunctions, ChainParts, chain_functions, chain_parts
from rope_model.numerics.newton import PROGRESS
from rope_model.physics import element
from rope_model.physics.air_element import AIR_BALANCE
from rope_model.physics.contact_element import CONTACT_BALANCE
from rope_model.physics.element import ELEMENT_DOF, NODE_DOF, ElementFidelity
from rope_model.physics.expressions import EXPRESSIONS
from rope_model.physics.rope_element import AIR, Features, kinds_touched, rope_element
from rope_model.physics.shaft import KINDS

log = logging.getLogger(__name__)

_WORDS = (*KINDS, "air", "wires", "curved")


class RopeKernels:
    """Functions of a chain of ``elements`` elements of one fidelity, called on arrays of shape (nodes, 7).

    Omitted degrees of freedom stay zero.  ``bundle`` is a folder written by ``write_bundle``.  Without it, or if it has
    no files for this size, fidelity and platform, or those of a newer CasADi, the functions are built from the element
    and compiled if possible.
    """

    def __init__(
        self,
        elements: int,
        form: compiling.KernelForm = "auto",
        bundle: Path | None = None,
        fidelity: ElementFidelity = "torsional",
        features: Features = (),
    ) -> None:
        library, portable = (
            _bundle_files(bundle, elements, fidelity, features) if bundle else (None, None)
        )
        with EXPRESSIONS:
            bundled = (
                compiling.load_portable(portable)
                if portable is not None and portable.exists()
                else []
            )
            functions = bundled or [*rope_functions(elements, fidelity, features)]
            kernels, self.form = compiling.prepare(
                functions, partial(_build, elements, fidelity, features), form, library
            )
        solve, newton_step, evaluate, losses, strains, momentum, reference, transport = kernels
        nodes, balance = (elements + 1, NODE_DOF), (evaluate.size1_out(1),)
        self.elements, self.fidelity, self.features = elements, fidelity, features
        # entries of the balance of solve and evaluate
        air, contact = (
            AIR_BALANCE if AIR in features else (),
            CONTACT_BALANCE if kinds_touched(features) else (),
        )
        self.balance = (*element.BALANCE, *air, *contact)
        self.solve = compiling.Kernel(
            solve, (nodes, nodes, nodes, nodes, balance, (len(PROGRESS),))
        )
        self.newton_step = compiling.Kernel(newton_step, (nodes, nodes))
        self.evaluate = compiling.Kernel(evaluate, (nodes, balance))
        self.losses = compiling.Kernel(losses, ((losses.size1_out(0),),))
        self.strains = compiling.Kernel(strains, ((elements, len(element.STRAINS)),))
        self.momentum = compiling.Kernel(momentum, ((len(element.MOMENTUM),),))
        self.reference = compiling.Kernel(reference, ((elements, reference.size1_out(0)),))
        self.transport = compiling.Kernel(transport, ((elements, 3),))


class KernelCache:
    """Kernels of every fidelity for one number of elements, made when first needed."""

    def __init__(
        self, elements: int, form: compiling.KernelForm = "auto", bundle: Path | None = None
    ) -> None:
        self.elements, self._form, self._bundle = elements, form, bundle
        self._kernels: dict[tuple[ElementFidelity, Features], RopeKernels] = {}

    def of(self, fidelity: ElementFidelity, features: Features = ()) -> RopeKernels:
        """Return the kernels for this fidelity and these features, built on first use."""
        if (fidelity, features) not in self._kernels:
            self._kernels[fidelity, features] = RopeKernels(
                self.elements, self._form, self._bundle, fidelity, features
            )
        return self._kernels[fidelity, features]


def write_bundle(
    elements: int, folder: Path, needed: Iterable[tuple[ElementFidelity, Features]]
) -> list[Path]:
    """Write the portable kernels ``needed`` and, with a compiler, those for this platform into ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    written, compiler = [], compiling.find_compiler()
    if compiler is None:
        log.warning(
            "no compiled kernels go into %s, for want of a C compiler: CasADi's virtual machine takes several times as "
            "long; install a compiler, or pip install 'balance-rope[compiler]'",
            folder.name,
        )
    for fidelity, features in needed:
        library, portable = _bundle_files(folder, elements, fidelity, features)
        compiling.save_portable(rope_functions(elements, fidelity, features), portable)
        written.append(portable)
        if compiler is not None:
            shutil.copyfile(_build(elements, fidelity, features, compiler), library)
            written.append(library)
    return written


def _build(
    elements: int, fidelity: ElementFidelity, features: Features, compiler: Sequence[str]
) -> Path:
    """Compile the library; the element's part, common to ropes of any length, is compiled only once."""
    kind = "-".join((fidelity, *(_WORDS[kind] for kind in features)))
    folder = compiling.cache_folder()
    library, linked = compiling.build_parts(
        rope_parts(fidelity, features), compiler, folder, f"element-{kind}"
    )
    functions = _linked_functions(elements, fidelity, features, library)
    return compiling.build_library(
        functions, compiler, folder, f"kernels-{kind}-{elements}", [linked]
    )


@cache
def _linked_functions(
    elements: int, fidelity: ElementFidelity, features: Features, library: Path
) -> ChainFunctions:
    """Return ``rope_functions`` that call the parts shared by ropes of any size."""
    parts = ChainParts(*compiling.load_compiled(rope_parts(fidelity, features), library))
    return chain_functions(elements, parts, NODE_DOF, ELEMENT_DOF[fidelity])


def _bundle_files(
    folder: Path, elements: int, fidelity: ElementFidelity, features: Features
) -> tuple[Path, Path]:
    name = "-".join((fidelity, *(_WORDS[kind] for kind in features), str(elements)))
    return (
        folder / f"{name}-{compiling.platform_tag()}{compiling.LIBRARY_SUFFIX}",
        folder / f"{name}.casadi",
    )


@cache
def rope_parts(fidelity: ElementFidelity, features: Features = ()) -> ChainParts:
    """Return the CasADi functions that ropes of any number of elements have in common."""
    e = rope_element(fidelity, features)
    return chain_parts(
        e.tangent, e.residual, e.balance, e.losses, e.strains, e.momentum, e.reference, e.transport
    )


@cache
def rope_functions(
    elements: int, fidelity: ElementFidelity = "torsional", features: Features = ()
) -> ChainFunctions:
    """Return the CasADi functions of a rope of ``elements`` elements with these features."""
    return chain_functions(
        elements, rope_parts(fidelity, features), NODE_DOF, ELEMENT_DOF[fidelity]
    )
