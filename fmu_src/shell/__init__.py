"""Shell of both flavours: C between the functions of FMI and a model, its tables and compilation.

fmi2.c, fmi3.c    every function of the standards; shell.inc has what both share
snapshot.c        states as objects of the host
component.c       values, rules of causality and variability, status, states; for any model
model.h           interface of a model; the models are native/rope_model.c, python/python_model.c
                  and hoist_demo/drive_fmu/drive_model.c
table             interface table as C
start             data of one export, as C and written into finished libraries
sources           the C files together
build             compilation for every platform; mach_o: libraries of macOS
"""
