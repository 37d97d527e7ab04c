"""Where the constants of the 'auto' mesh come from: measurements, fitted laws, and the constants held against them.

scenes     ropes and trips from a seed
statics    effect of one length of the mesh on a hanging rope, the others fine
trips      effect of the mesh on a winding
laws       the laws and their fits
rule       shares that the rule's lengths take of the error asked for

``python -m evidence.mesh_rule`` prints them from docs/data/mesh_rule; ``--measure`` measures that data anew.
"""
