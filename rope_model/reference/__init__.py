"""The reference rope: the published system in plain Python, to be read and to check the engine.

Each module solves one set of equations; names in brackets are those of docs/theory, such as
(eq-alpha).

    equations          R(q, v, a) = 0: 14-DOF elements on a mesh, with held nodes and loads
                       (eq-strains, eq-energies)
    elements           the element's functions for all elements of a mesh at once
    newton             R = 0 along q, v and a that follow each other (eq-tangent)
    statics            R(q, 0, 0) = 0, and the rope's first guess
    generalized_alpha  one time step (eq-alpha), its restart and its local error (eq-recentre)
    mesh               EEM and TMN-ETM: lengths of the elements, and when they are transformed
                       (eq-ladder, eq-grading)
    transfer           fields on a new mesh (eq-transfer)
    transformation     the rope on a new mesh
    ends               motions of the conveyances: quintics in time
    swivel             BRSR: stick and slip of the rope's ends (eq-swivel), boundary conditions
    hanging            the rope at rest: installed twist, swivels that have slid
    stepping           step-size control (eq-share), located swivel events, transformations
    energies           the balance of energy (eq-balance)
    outputs            end forces and torques, the loop's place, twist and stress
    state              all that the future depends on
    rope               BalanceRope between two conveyances
    scope              what a scene may hold

Costello's law is ``physics.costello``; the element's energies, and with them its forces and
tangents, are ``physics.element``, frames ``physics.frame``, friction ``physics.swivel``.

Units are SI.  Axes: X from the left to the right end, Y up, Z out of the plane.  Arrays of nodes
have the shape (nodes, 7): r, r' and theta.  The tangent is -Y at the left end and +Y at the right
one; twist and torque are positive about the tangent, yaw about Y.
"""
