"""Who takes part: the hoist, and a balance rope from an FMU or in this process.

rope_plant says what is asked of a rope; fmu_rope and inprocess_rope answer; fmi_versions has the calls of FMI 2.0 and
3.0; partners joins hoist and rope to a scheme.
"""
