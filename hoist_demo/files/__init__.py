"""Files that people write (TOML): values with units and status, reading, the parameters of runs.

Reader, messages and JSON Schema come from one declaration of every key. A rope's file is here; a
hoist's is in cases.
"""
