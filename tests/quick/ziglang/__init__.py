"""Stand-in for the ziglang package in processes that tests start."""
