"""What is known of a rope: the catalogue's table."""
