"""Simulation of the rope: state, equations of motion, time stepping, mesh, contact and outputs."""
