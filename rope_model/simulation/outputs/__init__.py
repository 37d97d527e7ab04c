"""Outputs of a running rope: signals, audit, derivatives, modes and linear models."""
