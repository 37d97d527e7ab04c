"""C text of CasADi expressions, for formulas, tables, rules and elements."""

import math
import re
from collections import Counter
from collections.abc import Sequence
from typing import Any, NamedTuple

import casadi as ca

_CHOICE, _LOGIC, _COMPARISON, _SUM, _PRODUCT, _SIGN, _ATOM = range(7)
_OPERATORS = {
    ca.OP_ADD: ("+", _SUM),
    ca.OP_SUB: ("-", _SUM),
    ca.OP_MUL: ("*", _PRODUCT),
    ca.OP_DIV: ("/", _PRODUCT),
}
_LOGICAL = {ca.OP_AND: "&&", ca.OP_OR: "||"}
_OPERATORS |= {ca.OP_LT: ("<", _COMPARISON), ca.OP_LE: ("<=", _COMPARISON)}
_OPERATORS |= {ca.OP_EQ: ("==", _COMPARISON), ca.OP_NE: ("!=", _COMPARISON)}
_LIBM = (
    "sqrt",
    "ceil",
    "floor",
    "exp",
    "log",
    "sin",
    "cos",
    "atan2",
    "hypot",
    "fabs",
    "pow",
    "copysign",
)
_CALLS = {getattr(ca, f"OP_{name.upper()}"): name for name in _LIBM}
_CALLS |= {
    ca.OP_CONSTPOW: "pow",
    ca.OP_FMAX: "maximum",
    ca.OP_FMIN: "minimum",
    ca.OP_SIGN: "sign_of",
}
_INFINITE = {math.inf: "INFINITY", -math.inf: "-INFINITY"}
#: length above which an expression gets a name
_LONG = 80


class _Text(NamedTuple):
    """Text of an expression, and its precedence."""

    text: str
    precedence: int
    #: parts of elementary.where, a sum of two products: condition and value of the first
    condition: str = ""
    value: str = ""

    def within(self, outer: int) -> str:
        """Return the text as an operand of an operator with the precedence ``outer``."""
        return self.text if self.precedence >= outer else f"({self.text})"


def texts_of(values: Sequence[Any]) -> tuple[list[str], list[str]]:
    """Return ``statements`` of expressions of symbols."""
    expressions = [ca.SX(value) for value in values]
    return statements(ca.Function("values", ca.symvar(ca.vertcat(*expressions)), expressions))


def statements(f: ca.Function, kind: str = "double") -> tuple[list[str], list[str]]:
    """Return lines that name repeated terms, and the texts of the results.

    Numbers have the type ``kind``.  With Vec a quotient is a product with the reciprocal, computed
    once for each divisor.
    """
    inputs = [[x.name() for x in ca.vertsplit(f.sx_in(i))] for i in range(f.n_in())]
    uses = _uses(f)
    values: dict[int, _Text] = {}  # present value of each entry of CasADi's work vector
    results: dict[tuple[int, ...], str] = {}
    reciprocals: dict[str, _Text] = {}
    lines: list[str] = []

    def named_text(text: str) -> _Text:
        lines.append(f"const {kind} t{len(lines)} = {text};")
        return _Text(f"t{len(lines) - 1}", _ATOM)

    def reciprocal(x: _Text) -> _Text:
        if is_number(x.text):
            return _Text(repr(1.0 / float(x.text)), _SIGN)
        if x.text not in reciprocals:
            reciprocals[x.text] = named_text(f"1.0 / {x.within(_PRODUCT + 1)}")
        return reciprocals[x.text]

    for k in range(f.n_instructions()):
        operation = f.instruction_id(k)
        sources = f.instruction_input(k)
        target = f.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            results[tuple(target)] = values[sources[0]].text
            continue
        if operation == ca.OP_CONST:
            value = f.instruction_constant(k)
            if value == math.pi:
                text = "PI"
            else:
                text = _INFINITE.get(value, repr(value))
            expression = _Text(text, _SIGN if value < 0 else _ATOM)
        elif operation == ca.OP_INPUT:
            expression = _Text(inputs[sources[0]][sources[1]], _ATOM)
        else:
            operands = [values[s] for s in sources]
            if kind == "Vec" and operation in (ca.OP_DIV, ca.OP_INV):
                *above, below = operands
                if above:
                    expression = _expression(ca.OP_MUL, [*above, reciprocal(below)], kind)
                else:
                    expression = reciprocal(below)
            else:
                expression = _expression(operation, operands, kind)
            if (
                (uses[k] > 1 or len(expression.text) > _LONG)
                and not expression.value
                and operation != ca.OP_NOT
            ):
                expression = named_text(expression.text)
        values[target[0]] = expression
    return lines, [results[index] for index in sorted(results)]


def is_number(text: str) -> bool:
    """Return whether the text of an expression is a plain number."""
    return re.fullmatch(r"-?[\d.]+(e[-+]\d+)?", text) is not None


def _uses(f: ca.Function) -> Counter[int]:
    """Count the uses of the result of each instruction."""
    made_by: dict[int, int] = {}
    uses: Counter[int] = Counter()
    for k in range(f.n_instructions()):
        if f.instruction_id(k) not in (ca.OP_INPUT, ca.OP_CONST, ca.OP_NOT):
            uses.update(made_by[s] for s in f.instruction_input(k))
        if f.instruction_id(k) != ca.OP_OUTPUT:
            made_by[f.instruction_output(k)[0]] = k
    return uses


def _opposite(one: str, other: str) -> bool:
    """Return whether a condition is the negation of the other, as in elementary.where, or only added to it."""
    return other in (f"!{one}", f"!({one})") or one in (f"!{other}", f"!({other})")


def _expression(operation: int, operands: Sequence[_Text], kind: str) -> _Text:
    if operation == ca.OP_NEG:
        return _Text(f"-{operands[0].within(_ATOM)}", _SIGN)
    if operation in _CALLS:
        if kind == "double":
            name = _CALLS[operation]
        else:
            name = f"{_CALLS[operation].upper()}_{kind}"
        return _Text(f"{name}({', '.join(x.text for x in operands)})", _ATOM)
    if operation in (ca.OP_SQ, ca.OP_TWICE):
        if operation == ca.OP_TWICE:
            twice = _Text("2.0", _ATOM)
        else:
            twice = operands[0]
        operation = ca.OP_MUL
        operands = [twice, operands[0]]
    if operation == ca.OP_NOT:
        return _Text(f"!{operands[0].within(_ATOM)}", _SIGN)
    if operation == ca.OP_IF_ELSE_ZERO:
        condition, value = (x.within(_COMPARISON) for x in operands)
        return _Text(f"{condition} ? {value} : 0.0", _CHOICE, condition, value)
    left, right = operands
    if operation in _LOGICAL:  # compilers warn without brackets where both meet
        return _Text(
            f"{left.within(_COMPARISON)} {_LOGICAL[operation]} {right.within(_COMPARISON)}", _LOGIC
        )
    if left.value and right.value and _opposite(left.condition, right.condition):
        return _Text(f"{left.condition} ? {left.value} : {right.value}", _CHOICE)
    sign, precedence = _OPERATORS[operation]
    # the right side binds tighter, as it is computed first
    return _Text(f"{left.within(precedence)} {sign} {right.within(precedence + 1)}", precedence)
