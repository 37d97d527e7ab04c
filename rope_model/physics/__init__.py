"""Laws of the rope, its ends, its contacts and the air."""
