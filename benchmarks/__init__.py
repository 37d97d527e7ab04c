"""Measurements of speed, throughput and robustness: each module prints a table; ``make`` or ``python -m`` runs it."""
