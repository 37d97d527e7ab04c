"""The model against measurement, theory and other codes; docs/validation.md has their rows.

row        a line of the page's table: reference, result, acceptance, test
wires      measured: the twist at which hanging wires throw a loop
poses      measured: shapes of wires that a robot holds
chains     a folded rope that is let go (falling), a rope that hangs by one end
onset      theory: the torque at which a clamped rod buckles
buckle     theory: the buckle in which a long rod's slack gathers
cabledyn   a second code: a winding of a twisted U
coupled    the same code: a coupled rope, by an uncoupled one that is equivalent
measure    all rows of this room; discrete_rod, peer and contact have theirs
page       the page validation.md.j2
"""
