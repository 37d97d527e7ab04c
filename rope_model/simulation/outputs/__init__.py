"""What a running rope shows: signals, checks, derivatives and modes."""
