"""All that is wrong with data at once, rather than the first of it."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Self


class Problems(list[str]):
    """List of problems, a line each; the end of its ``with`` raises them together."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.refuse()

    @contextmanager
    def at(self, key_path: str) -> Iterator[None]:
        """Collect what is refused inside, each line behind its key path."""
        try:
            yield
        except ValueError as error:
            before = f"{key_path}: " if key_path else ""
            self += [f"{before}{line}" for line in str(error).splitlines() or [repr(error)]]

    def refuse(self) -> None:
        """Raise a ValueError with all problems, if there are any."""
        if self:
            raise ValueError("\n".join(self))
