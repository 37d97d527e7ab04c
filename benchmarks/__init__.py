"""Measurements of speed, throughput and robustness.

Each module prints a table; ``make`` or ``python -m`` runs it.
"""
