"""A hoist as FMUs and as one system: the room that joins drive_fmu with fmu_src."""
