"""Text with placeholders for values, which Python and C fill in alike."""

from string import Formatter


class Template:
    """Text with a named placeholder for each value, as in ``{x:.3g}``; it is called with the values in their order.

    A placeholder is that of a real number; with ``d`` of an integer, with ``s`` or a length alone
    of a text.
    """

    def __init__(self, template: str) -> None:
        #: text before each placeholder, its name and its format, '' behind the last
        self.parts = [
            (before, name or "", spec or "")
            for before, name, spec, _ in Formatter().parse(template)
        ]
        #: type of each value by name
        self.kinds = {name: _kind(spec) for _, name, spec in self.parts if name}
        self._template = template

    def __call__(self, *values: float | str) -> str:
        """Return the text with these values."""
        return self._template.format(**dict(zip(self.kinds, values, strict=True)))


def _kind(spec: str) -> type[float | int | str]:
    if spec == "d":
        return int
    return str if spec == "s" or spec.strip(".").isdigit() else float
