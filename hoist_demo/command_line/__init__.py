"""The commands `balance-rope demo`, `study`, `duty` and `ropes`: all of this package that prints."""
