"""A hoist as a whole: hoist, trip, controller gains and ropes, by name or from a file.

Reads from top to bottom as case -> rules -> hoist_file (hoists/*.toml) -> table -> run_values; new
and writing make the file of a new hoist.
"""
