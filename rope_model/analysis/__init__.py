"""Analysis of ropes in Python, over the states and matrices that the engine gives.

modes            natural modes and stability of an equilibrium
linear           linear models at rest, or of a rope that flows through its shape
element_data     arguments of the element's functions at the engine's present state
neighbours       ropes that press each other; pair_contact: contact of two of them

Nothing that an FMU needs is here: modes and linear models take scipy.
"""
