"""Invariants: relations that must hold for any scene and motion, tried on scenes from a seed.

features   what a scene can have, each part drawn by itself
motions    how the ends move
case       a scene with its motion and its communication steps, of (seed, number)
runs       a case wound, and two records compared
symmetries, books, neutral, steps, states, hosts    the relations
hunt       cases x relations, findings made smaller; python -m invariants
"""
