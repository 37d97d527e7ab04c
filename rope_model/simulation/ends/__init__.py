"""Ends of the rope: input filters, paths and swivels."""
