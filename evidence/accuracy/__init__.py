"""Accuracy against speed: ``make accuracy`` winds the 120 m rope with many meshes, steps and models.

points -> measure -> tables (CSV) -> front -> figures and page.  Figures, page and README's table are drawn from the
CSV files alone.
"""
