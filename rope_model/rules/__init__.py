"""Tables, and formulas of the method, from which the engine's C and the reference rope are made."""
