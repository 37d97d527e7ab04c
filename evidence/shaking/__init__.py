"""Ends that shake sideways: errors of the end forces and of the loop, and the estimates of them."""
