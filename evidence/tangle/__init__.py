"""Does a deep rope tangle?  One hoist of 690 m, from swivels that turn to swivels that are seized.

scenes   the hoist, its shaft, and what is changed in it
wind     one trip of it, and what the rope strikes
page     docs/tangle.md; figures has its pictures
"""
