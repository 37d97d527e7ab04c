"""Schemes by which a drive and a rope exchange forces and motions, all interchangeable.

Reads as interface -> explicit, iterative, energy -> catalogue, stability.

The drive takes forces and gives motions, the rope takes motions and gives forces; a scheme advances
both over one communication step H. Schemes hold for any partners: n interface coordinates, forces
on the drive in N (or N m), motions in m (or rad). Over a step, s runs from 0 to 1.
"""
