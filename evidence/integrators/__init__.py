"""Methods of time integration on one rope: the product's native sources with another step.

Mesh, transformations, swivels, Newton's method and outputs are the product's; ``study.c`` brings the steps.
"""
