"""Files that people write (TOML): one declaration of every key, from which come reader, messages and JSON Schema."""
