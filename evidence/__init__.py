"""Pages of evidence.

measure -> tables (CSV in docs/data) -> numbers of a page -> template (*.md.j2) -> docs/*.md.  A package per subject
measures (``measure.py``; ``python -m evidence --measure accuracy``) and computes the numbers from the tables
(``page.py``); ``python -m evidence`` writes pages and figures from the tables as they are.
"""
