"""How long one communication step takes, and what makes the longest ones long: ``make latency``, docs/latency.md."""
