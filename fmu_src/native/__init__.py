"""The FMUs in C99: between the FMI functions and the rope simulator, in C or in Python.

fmi2.c, fmi3.c        the shells: every function of the standards, of those that both have alike shell.inc
component.c           values, rules of causality and variability, status, states; of any model
rope_model.c          the rope as such a model
python_model.c        a model in Python: of the Python flavour
export                the FMU of the rope, or of any model, with the files that every FMU has
table                 the interface table as C
build                 compiles for every platform
"""
