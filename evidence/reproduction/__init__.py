"""The source's evaluation, run anew: ``make reproduce``.

Data flows one way.  The modules that measure (frequencies, windings, costs, release) make tables, which are written
as CSV; claims, figures and the page are made from the tables as they are read back, and from nothing else.
"""
