"""Physical laws as formulas and elements: the rope, its ends, contact, guards and air."""
