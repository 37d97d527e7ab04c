"""Where the constants of the 'auto' mesh come from: measurements, fits, and docs/mesh_rule.md.

scenes     ropes and trips from a seed
statics    what one length of the mesh does to a hanging rope, the others fine
trips      what it does on a winding; asked against achieved errors
laws       the laws, their fits, and the constants of the rule held against them
page       what the page mesh_rule.md.j2 says, and its figure
"""
