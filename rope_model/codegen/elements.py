"""C text of the element: all its functions as straight-line code for several elements at once.

The type Vec contains one number each of LANES elements (see lanes.h); the text is the same for all
widths.  A quotient becomes a product with the reciprocal, which is computed once for each divisor,
as division is the most expensive.
"""

from collections.abc import Iterator

import casadi as ca

from rope_model.codegen.expressions import is_number, statements
from rope_model.physics.air_element import air_functions
from rope_model.physics.curved_element import curved_functions
from rope_model.physics.element import ELEMENT_DOF, ENERGIES, ElementFidelity, element_functions
from rope_model.physics.wire_element import wire_functions


def element_code() -> str:
    """Return all element functions, as ``torsional_tangent``; arguments are arrays of Vec, the last is the result."""
    functions = (
        _function_code(name, f) for fidelity in ELEMENT_DOF for name, f in _functions(fidelity)
    )
    return "\n".join((_dofs(), *functions))


def _dofs() -> str:
    """Return, for each fidelity, the degrees of freedom of a node that it keeps, and their number."""
    return "".join(
        f"#define {fidelity.upper()}_DOFS {{{', '.join(map(str, dofs))}}}\n"
        f"#define {fidelity.upper()}_NDOF {len(dofs)}\n"
        for fidelity, dofs in ELEMENT_DOF.items()
    )


def _functions(fidelity: ElementFidelity) -> Iterator[tuple[str, ca.Function]]:
    e = element_functions(fidelity)
    yield f"{fidelity}_tangent", _upper_half("tangent", e.tangent)
    inputs = e.balance.sx_in()
    energies = e.balance(*inputs)[: len(ENERGIES)]
    yield f"{fidelity}_balance", ca.Function("balance", inputs, [ca.cse(energies)])
    for name in ("residual", "losses", "strains", "momentum"):
        yield f"{fidelity}_{name}", getattr(e, name)
    air = air_functions(fidelity)
    yield f"{fidelity}_air_residual", air.residual
    yield f"{fidelity}_air_sums", air.sums
    yield f"{fidelity}_air_tangent", _upper_half("air_tangent", air.tangent)
    wires = wire_functions(fidelity)
    yield f"{fidelity}_wire_residual", wires.residual
    yield f"{fidelity}_wire_energy", wires.energy
    inputs = wires.tangent.sx_in()
    tangent = ca.vertcat(
        _upper_half("wire_tangent", wires.tangent)(*inputs), wires.latest(*inputs[:-1])
    )
    yield f"{fidelity}_wire_tangent", ca.Function("wire_tangent", inputs, [ca.cse(tangent)])
    if fidelity == "torsional":
        curved = curved_functions()
        yield "torsional_curved_residual", curved.residual
        yield "torsional_curved_energy", curved.energy
        yield "torsional_curved_tangent", _upper_half("curved_tangent", curved.tangent)
        yield "torsional_reference", e.reference
        inputs = e.transport.sx_in()
        transport = ca.vertcat(e.transport(*inputs), e.reference(inputs[0], inputs[3]))
        yield "torsional_transport", ca.Function("transport", inputs, [ca.cse(transport)])


def _name_of(symbols: ca.SX) -> str:
    """Return the name of an argument: that of its symbols; a fidelity without frames has no symbols for F."""
    if symbols.numel() == 0:
        return "F"
    first = str(symbols[0].name())
    return first if symbols.numel() == 1 else first.removesuffix("_0")


def _upper_half(name: str, tangent: ca.Function) -> ca.Function:
    """Build the function of the last result of ``tangent``, a symmetric matrix, as its upper half row by row."""
    inputs = tangent.sx_in()
    J = ca.densify(tangent.call(inputs)[-1])
    half = ca.vertcat(*(J[i, j] for i in range(J.shape[0]) for j in range(i, J.shape[1])))
    return ca.Function(name, inputs, [ca.cse(half)])


def _function_code(name: str, f: ca.Function) -> str:
    inputs = [_name_of(symbols) for symbols in f.sx_in()]
    symbols = [
        ca.vertcat(*(ca.SX.sym(f"{x}[{k}]") for k in range(f.numel_in(i))))
        for i, x in enumerate(inputs)
    ]
    arguments = "".join(f"const Vec *RESTRICT {x}, " for x in inputs)
    lines, texts = statements(ca.Function(name, symbols, f.call(symbols)), "Vec")
    lines = [*(f"(void){x};" for x in inputs), *lines]
    lines += [
        f"y[{k}] = {f'SPLAT({text})' if is_number(text) else text};" for k, text in enumerate(texts)
    ]
    return (
        f"static void {name}({arguments}Vec *RESTRICT y) {{\n"
        + "".join(f"    {line}\n" for line in lines)
        + "}\n"
    )
