"""The balance rope as an FMU for co-simulation: the rope in Python (FMI 2.0), or all native C (FMI 2.0 and 3.0)."""

from rope_model.version import __version__ as __version__
