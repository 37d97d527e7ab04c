"""The commands `balance-rope demo` and `balance-rope study`: all of this package that prints."""
