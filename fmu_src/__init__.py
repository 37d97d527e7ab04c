"""Export of the balance rope as an FMU for co-simulation.

interface             table of the FMI variables; profile selects them, and gathers arrays for FMI 3.0
model_description     table as XML of FMI 2.0 and 3.0, with units and declared types
shell                 FMI functions and rules of values, modes and states in C, for every model; their compilation
native                FMU of the native flavour: the rope in C behind the shell
python                FMU of the Python flavour: the reference rope behind the shell
attachments           further files of both: documentation, licences, icons, terminals, reference results
"""

from rope_model.version import __version__ as __version__
