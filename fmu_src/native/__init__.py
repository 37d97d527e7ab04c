"""FMU of the native flavour, and FMUs of any other model in C.

rope_model.c      the rope in C as a model of the shell
places            place of each variable in the rope, as C
prefix            names of the functions of a source FMU
export            builds the .fmu
"""
