"""FMU of the Python flavour.

flavour       its variables, its scenes, its description
slave         the reference rope behind the FMI functions of the native flavour
own_modules   modules of this project as they travel in the FMU
export        builds the .fmu, with pythonfmu's builder
"""
