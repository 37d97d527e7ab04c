"""Drive and rope in one run: the participants, the schemes that couple them, and the host's loop around both."""
