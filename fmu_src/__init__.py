"""The balance rope as an FMU for co-simulation: packaged with pythonfmu (FMI 2.0), or native C (FMI 2.0 and 3.0).

interface             the one table of the FMI variables; arrays gathers them for FMI 3.0
component             the table joined to the rope: initialisation, steps, states; knows nothing of pythonfmu
model_description     the table as XML of FMI 2.0; model_description3 of FMI 3.0; units and declared types of both
slave                 the class that pythonfmu loads
export                builds the .fmu of the Python flavour
native                the same in C, for every platform
attachments           what lies beside in both: documentation, licences, icons, terminals, reference results
"""

from rope_model.version import __version__ as __version__
