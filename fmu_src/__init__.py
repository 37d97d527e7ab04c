"""The balance rope as an FMU for co-simulation (FMI 2.0), packaged with pythonfmu.

interface             the one table of the FMI variables
component             the table joined to the rope: initialisation, steps, states; knows nothing of pythonfmu
model_description     the table as XML
slave                 the class that pythonfmu loads
export                builds the .fmu
"""
