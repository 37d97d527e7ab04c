"""Studies: many windings over chosen parameters, each a co-simulation with the FMU, into one table.

Reads from top to bottom as units -> catalogue -> definition (the TOML file, checked) -> sampling -> run -> metrics
-> store -> cluster -> command.
"""
