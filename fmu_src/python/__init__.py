"""FMU of the Python flavour.

flavour           its variables, its scenes, its description
python_model.c    a model of the shell whose functions call an object of Python
slave             the reference rope as that object
own_modules       modules of this project as they travel in the FMU
export            builds the .fmu, with pythonfmu's builder
"""
