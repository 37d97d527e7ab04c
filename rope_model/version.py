"""Version of the package, from its metadata."""

from importlib.metadata import PackageNotFoundError, version

try:
    __version__ = version("balance-rope")
except PackageNotFoundError:  # a checkout that is not installed
    __version__ = "unknown"
