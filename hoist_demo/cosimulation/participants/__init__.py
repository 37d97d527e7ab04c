"""Who takes part: the hoist, and a balance rope from an FMU or in this process; schemes.interface asks it of them."""
