"""The reference of a trip, the controller that follows it, and the emergency brake."""
