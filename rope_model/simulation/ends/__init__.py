"""The ends of the rope: their motions, and the swivels that hold them."""
