"""Subcommands of balance-rope: all of hoist_demo that prints.

What loads slowly is imported where it is needed.
"""
