"""Windings by name: hoist, trip, controller gains and balance rope; case -> installed -> table."""
