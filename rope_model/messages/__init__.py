"""Messages and warnings of the rope: their texts, and the form of the tables that select them."""
