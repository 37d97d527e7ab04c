"""Installed hoists with dead weights for their balance ropes: figures, data and a table of docs/howto/hoist.md."""
