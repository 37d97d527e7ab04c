"""Drive and rope in one run: participants, schemes that couple them, and the host's loop."""
