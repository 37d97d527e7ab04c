"""Hoists by name or file: hoist, trip, controller gains and ropes; case -> rules -> table."""
