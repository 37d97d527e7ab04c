"""What is wound: hoist, trip, controller gains and balance rope by name; case -> installed -> table."""
