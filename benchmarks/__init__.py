"""Measurements: each module prints a table or writes a page of docs; run them with ``make`` or ``python -m``."""
