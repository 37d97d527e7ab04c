"""Warnings about valid results."""
