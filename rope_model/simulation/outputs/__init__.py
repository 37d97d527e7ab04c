"""Outputs of a running rope: signals, checks, derivatives and modes."""
