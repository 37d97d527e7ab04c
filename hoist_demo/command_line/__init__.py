"""The commands `balance-rope demo`, `study` and `duty`: all of this package that prints."""
