"""The hoist as a model: motor, sheave, head ropes and conveyances.

Reads as coordinates -> friction -> legs -> sliding -> equations -> integrator -> plant.
"""
