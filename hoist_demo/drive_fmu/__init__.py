"""The hoist drive as an FMU: plant, reference and controller, with the rope's names of variables.

interface        the table of the FMI variables
kernels          plant and control law as C, generated from the symbolic model
drive_model.c    the model behind the FMI shell: time, memory, states
description      table, sources and numbers for a builder of FMUs
"""
