"""Contact with bodies in the shaft, and of the rope with itself, against what is exact, and docs/contact.md.

rebound    a rope that strikes a floor flat: speed after it, order in the step
scenes     ropes that lie on a floor, fall on it, slide around a divider, and strike bodies of every kind
crossed    two strings that cross
turned     legs that are turned about each other
plectoneme a rod in tension that winds up, against its closed form
neighbours two ropes that swing against each other, against a wall midway
slack_rod  a slack rod turned until its loop lies on itself; elastica_rod the same in PyElastica
page       the checks, and what the page contact.md.j2 says
"""
