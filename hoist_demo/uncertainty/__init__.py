"""From what is not known of a rope to what is not known of its winding, and which datum causes it."""
