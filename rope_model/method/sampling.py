"""Samples of the centreline from which the engine takes its lowest point, clearances and turns."""

PIECES = 8  #: straight pieces of an element, for the turns: legs in contact must not seem to pass through each other
FINE = 41  #: samples of two elements, for the lowest point
OUTLINE = 161  #: samples of the rope, for the clearance of the legs
