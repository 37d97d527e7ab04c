"""An independent check: the rope as a discrete rod on scipy's integrators, beside rope_model."""
