"""The FMUs in C99: between the FMI functions and the rope simulator, in C or in Python."""
