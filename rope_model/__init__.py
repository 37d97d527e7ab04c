"""A balance rope of a friction hoist: tension, torsion and lateral motion, coupled.

Conventions, everywhere in this package
---------------------------------------
Units are SI; the unit stands on every field that is not obvious.  X is horizontal in the plane of the hanging loop
(from the left suspension point to the right one), Y is up, Z = X x Y is horizontal out of plane.  Arc length s runs
from the left end to the right end, so the tangent is -Y at the left end and +Y at the right end.  Twist, torque and
theta are positive about the tangent.  The conveyance's yaw and the loop's yaw are positive about Y.  Signals called
fx ... mz are what the rope does to the conveyance.

Layers, imports point down only
-------------------------------
    simulation            joins physics and methods: statics, stepping, swivel events, transformation, modes
    physics | numerics    what the rope is; how such systems are solved; strangers to each other
    parameters            data sets
"""
