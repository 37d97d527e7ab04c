"""The hoist as a model: motor, sheave, head ropes and conveyances.

Reads as legs -> equations -> integrator -> plant.
"""
