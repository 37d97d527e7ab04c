"""Times of single communication steps, as a host in real time meets them."""
