"""The trip asked for, the controller that follows it, and the emergency brake."""
