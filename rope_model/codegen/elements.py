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
from rope_model.physics.element import BALANCE, ELEMENT_DOF, ElementFidelity, element_functions
from rope_model.physics.wire_element import wire_functions


def element_code() -> str:
    """Return all element functions, as ``torsional_tangent``; arguments are arrays of Vec, the last is the result."""
    return "\n".join(
        _function_code(name, f) for fidelity in ELEMENT_DOF for name, f in _functions(fidelity)
    )


def _functions(fidelity: ElementFidelity) -> Iterator[tuple[str, ca.Function]]:
    e = element_functions(fidelity)
    yield f"{fidelity}_tangent", _upper_half("tangent", e.tangent)
    inputs = e.balance.sx_in()
    energies = e.balance(*inputs)[: BALANCE.index("damping_power")]
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


def _upper_half(name: str, tangent: ca.Function) -> ca.Function:
    """Build the function of the last result of ``tangent``, a symmetric matrix, as its upper half row by row."""
    inputs = tangent.sx_in()
    J = ca.densify(tangent.call(inputs)[-1])
    half = ca.vertcat(*(J[i, j] for i in range(J.shape[0]) for j in range(i, J.shape[1])))
    return ca.Function(name, inputs, [ca.cse(half)])


def _function_code(name: str, f: ca.Function) -> str:
    inputs = range(f.n_in())
    symbols = [ca.vertcat(*(ca.SX.sym(f"x{i}[{k}]") for k in range(f.numel_in(i)))) for i in inputs]
    arguments = "".join(f"const Vec *RESTRICT x{i}, " for i in inputs)
    lines, texts = statements(ca.Function(name, symbols, f.call(symbols)), "Vec")
    lines = [*(f"(void)x{i};" for i in inputs), *lines]
    lines += [
        f"y[{k}] = {f'SPLAT({text})' if is_number(text) else text};" for k, text in enumerate(texts)
    ]
    return (
        f"static void {name}({arguments}Vec *RESTRICT y) {{\n"
        + "".join(f"    {line}\n" for line in lines)
        + "}\n"
    )
