"""Contact with bodies in the shaft, and of the rope with itself, against what is exact, and docs/contact.md.

scenes     ropes that lie on a floor, fall on it, slide around a divider, and strike bodies of every kind
brush      a thin divider against step and mesh; estimates fits the constants of the error's estimate
wall       a leg that swings against a wall, against a chain of its own
rebound    a rope that strikes a floor flat
turned     legs that are turned about each other
plectoneme a rod in tension that winds up, against its closed form
measure    the checks, and the tables of brush
page       what the page contact.md.j2 says
"""
