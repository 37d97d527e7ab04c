"""Where to set a guard of the loop: seeded windings in a shaft, healthy ones and foulings, docs/guards.md.

scenes     ropes, swivels, shafts and trips from a seed
wind       a winding up to its first fouling, and how far each watched quantity has gone by then
judging    false trips against missed ones over the threshold
page       what the page guards.md.j2 says; figures
"""
