"""Generation of the C that both forms of the rope share, and the build of the native library."""
