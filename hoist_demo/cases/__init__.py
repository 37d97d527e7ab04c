"""What is wound: hoist, winding, controller gains and balance rope by name."""
