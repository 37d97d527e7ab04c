"""The coupling schemes compared: ``python -m evidence.coupling`` writes docs/coupling.md with its figures and data.

oscillator (exact solution), hoist (runs of the cases), light (stability over mass and step) -> command -> figures,
page.  Figures and page are drawn from the CSV files alone.
"""
