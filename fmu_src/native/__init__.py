"""FMUs in C99: the layer between the FMI functions and the rope simulator, in C or in Python.

fmi2.c, fmi3.c        shells with every function of the standards; shell.inc has those that both
share component.c           values, rules of causality and variability, status, states; for any
model rope_model.c          the rope as such a model python_model.c        a model in Python, for
the Python flavour export                FMU of the rope, or of any model, with the files that every
FMU has table                 interface table as C build                 compilation for every
platform
"""
