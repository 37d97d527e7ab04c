"""Files that people write (TOML).

Reader, messages and JSON Schema come from one declaration of every key.
"""
