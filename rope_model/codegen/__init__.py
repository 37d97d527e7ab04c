"""Printers of the generated C, and the build of the native library."""
