"""Subcommands of balance-rope: all of hoist_demo that prints."""
