"""Who takes part: the hoist, and a balance rope from an FMU or in this process.

schemes.interface says what is asked of both; hoist_partner answers for the hoist, fmu_rope and inprocess_rope for a
rope; fmi_versions has the calls of FMI 2.0 and 3.0.
"""
