"""CasADi expressions without simplification, so that Python and C round alike."""

from collections.abc import Iterator
from contextlib import contextmanager
from threading import RLock

import casadi as ca


@contextmanager
def no_simplification() -> Iterator[None]:
    """Keep every operation of expressions that are built meanwhile."""
    with EXPRESSIONS:
        before = ca.GlobalOptions.getSimplificationOnTheFly()
        ca.GlobalOptions.setSimplificationOnTheFly(False)
        try:
            yield
        finally:
            ca.GlobalOptions.setSimplificationOnTheFly(before)


#: lock for building expressions: CasADi's simplification is an option of the whole process
EXPRESSIONS = RLock()
