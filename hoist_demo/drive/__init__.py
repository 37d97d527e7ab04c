"""The hoist as a model: motor, sheave, head ropes and conveyances; equations -> plant (loads)."""
