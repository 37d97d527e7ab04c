"""Version of the package, from its metadata."""

from importlib.metadata import PackageNotFoundError, version

try:
    __version__ = version("balance-rope")
except PackageNotFoundError:  # a copy in an FMU, whose description has the version
    __version__ = "unknown"
