"""The native FMU: C99 between the FMI functions and the rope simulator in C.

fmi2.c, fmi3.c        the shells: every function of the standards
component.c           values, rules of causality and variability, status, states; of any model
rope_model.c          the rope as such a model
table                 the interface table as C
build                 compiles for every platform
"""
