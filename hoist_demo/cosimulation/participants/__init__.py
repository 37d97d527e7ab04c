"""Participants of the co-simulation: the hoist, and a balance rope from an FMU or in this process.

schemes.interface has the protocols of both; hoist_partner implements that of the hoist, fmu_rope
and inprocess_rope that of a rope; fmi_versions has the calls of FMI 2.0 and 3.0.
"""
