"""The hoist as a model: motor, sheave, head ropes and conveyances; legs -> equations -> integrator -> plant."""
