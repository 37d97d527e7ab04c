"""Memory of a controller as JSON and back, equal to the bit.

None, bool, int, float, str, bytes; NumPy numbers and arrays; lists, tuples, dictionaries, data
classes and named tuples of all these. Of a class only its name is written: it must be known by name
where the text is read, and reading runs nothing but NumPy's own code.
"""

import json
import sys
import zipfile
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

Arrays = dict[str, NDArray[Any]]
KINDS = (
    "numbers, texts, bytes, NumPy arrays, "
    "and lists, tuples, dictionaries, data classes and named tuples of them"
)
_NUMERIC = "biufc"  #: NumPy's letters of booleans, integers, reals and complex numbers.


def encode(value: object, name: str, arrays: Arrays) -> Any:
    """Return plain data for JSON; ValueError for other data.

    Arrays and bytes go into ``arrays``, by names that begin with ``name`` and tell their place.
    """
    kind = type(value)
    if value is None or kind in (bool, int, float, str):
        return value
    if isinstance(value, list) and kind is list:
        return [encode(x, f"{name}[{k}]", arrays) for k, x in enumerate(value)]
    if isinstance(value, tuple) and kind is tuple:
        return {"tuple": encode(list(value), name, arrays)}
    if isinstance(value, dict) and kind is dict:
        keys = [encode(key, f"key {k} of {name}", arrays) for k, key in enumerate(value)]
        values = [encode(x, f"{name}[{k!r}]", arrays) for k, x in value.items()]
        return {"dict": [*zip(keys, values, strict=True)]}
    if isinstance(value, bytes) and kind is bytes:
        return {"bytes": _store_array(np.frombuffer(value, np.uint8), name, arrays)}
    if isinstance(value, np.ndarray | np.generic) and value.dtype.kind in _NUMERIC:
        tag = "array" if kind is np.ndarray else "number"
        return {tag: _store_array(np.asarray(value), name, arrays)}
    return {"class": _encode_record(value, name, arrays)}


def _encode_record(value: object, name: str, arrays: Arrays) -> list[Any]:
    """Return module, name and contents of a data class or named tuple; ValueError for others."""
    kind = type(value)
    names = _fields(kind)
    if names is not None and _class(kind.__module__, kind.__qualname__) is kind:
        contents = {
            field: encode(getattr(value, field), f"{name}.{field}", arrays) for field in names
        }
        return [kind.__module__, kind.__qualname__, contents]
    at_top = ""
    if names is not None:
        at_top = ", and classes must stand at the top of their module"
    raise ValueError(
        f"{name} is of type {kind.__qualname__}, which no checkpoint can keep: "
        f"it must be plain data ({KINDS}){at_top}; keep such data in the controller's state, "
        "and what never changes in the controller itself"
    )


def to_bytes(value: object) -> bytes:
    """Return plain data as bytes; ValueError for others."""
    arrays: Arrays = {}
    text = json.dumps(encode(value, "state", arrays))
    file = BytesIO()
    members = {f"array {k}": x for k, x in arrays.items()}
    np.savez(file, text=np.frombuffer(text.encode(), np.uint8), **members)  # type: ignore[arg-type]
    return file.getvalue()


def from_bytes(data: bytes) -> Any:
    """Return the plain data that ``to_bytes`` was given; ValueError for other bytes."""
    try:
        with np.load(BytesIO(data), allow_pickle=False) as file:
            arrays = {name.removeprefix("array "): file[name] for name in file.files}
        return decode(json.loads(arrays.pop("text").tobytes()), arrays)
    except (KeyError, TypeError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise ValueError(
            f"the state must be plain data of this version, but: {error}: start anew"
        ) from error


def _store_array(array: NDArray[Any], name: str, arrays: Arrays) -> str:
    """Keep an array; return its name, with a number where another one has that."""
    if name in arrays:
        name = f"{name} ({len(arrays)})"
    arrays[name] = array
    return name


def decode(value: Any, arrays: Arrays) -> Any:
    """Decode the data that ``encode`` was given."""
    if isinstance(value, list):
        return [decode(x, arrays) for x in value]
    if not isinstance(value, dict):
        return value
    ((kind, content),) = value.items()
    return _READERS[kind](content, arrays)


def _fields(kind: type[Any]) -> tuple[str, ...] | None:
    """Return the field names of a data class or named tuple; None for another class."""
    if is_dataclass(kind):
        return tuple(field.name for field in fields(kind))
    if not issubclass(kind, tuple):
        return None
    names: tuple[str, ...] | None = getattr(kind, "_fields", None)
    return names


def _class(module: str, name: str) -> Any:
    """Return a loaded class by its name; None if there is none."""
    target: Any = sys.modules.get(module)
    for part in name.split("."):
        target = getattr(target, part, None)
    return target


def _construct(content: list[Any], arrays: Arrays) -> Any:
    """Construct a data class or named tuple with these values."""
    module, name, contents = content
    kind = _class(module, name)
    names = None
    if isinstance(kind, type):
        names = _fields(kind)
    if names is None or set(names) != set(contents):
        raise ValueError(
            f"the checkpoint's controller remembers a {module}.{name} with "
            f"{', '.join(contents) or 'nothing'}, which is not known here: "
            "import that module, in the version that wrote it, before reading"
        )
    values = {field: decode(x, arrays) for field, x in contents.items()}
    if issubclass(kind, tuple):
        return tuple.__new__(kind, (values[field] for field in names))
    record = object.__new__(kind)
    for field, x in values.items():
        # frozen classes too, and without __post_init__, which might change the values
        object.__setattr__(record, field, x)
    return record


_READERS: dict[str, Callable[[Any, Arrays], Any]] = {
    "tuple": lambda content, arrays: tuple(decode(content, arrays)),
    "dict": lambda content, arrays: {decode(key, arrays): decode(x, arrays) for key, x in content},
    "bytes": lambda content, arrays: arrays[content].tobytes(),
    "array": lambda content, arrays: arrays[content].copy(),
    "number": lambda content, arrays: arrays[content][()],
    "class": _construct,
}
