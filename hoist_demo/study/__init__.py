"""Studies: many windings over chosen parameters, each a co-simulation with the FMU, into one table.

Reads from top to bottom as definition (the TOML file, checked) -> sampling -> outcome ->
provenance -> objective -> store -> cluster -> trends -> perform. The command is in
`command_line`.
"""
