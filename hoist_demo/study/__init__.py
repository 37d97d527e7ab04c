"""Studies: many runs over chosen parameters, each a co-simulation with the FMU, into one table.

Reads from top to bottom as definition (the TOML file, checked) -> provenance -> sampling ->
outcome (of one run) -> objective -> store -> cluster -> trends -> perform. One run is in
``hoist_demo.run``, the command in ``command_line``.
"""
