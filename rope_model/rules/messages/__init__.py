"""Messages and warnings of the rope, and the rules that select them."""
