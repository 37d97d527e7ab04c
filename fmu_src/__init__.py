"""The balance rope as an FMU for co-simulation: the rope in Python (FMI 2.0), or all native C (FMI 2.0 and 3.0).

interface             the one table of the FMI variables; profile chooses, and gathers arrays for FMI 3.0
model_description     the table as XML of FMI 2.0 and 3.0, with units and declared types
native                the FMI functions and the rules of values, modes and states in C, of both flavours; the native FMU
slave                 the Python flavour's rope behind them
export                builds the .fmu of the Python flavour, with pythonfmu's builder
attachments           what lies beside in both: documentation, licences, icons, terminals, reference results
"""

from rope_model.version import __version__ as __version__
