"""One run: its data, its ropes, its winding, and what is read from its record.

Reads from top to bottom as data -> provenance -> ropes -> complete_file -> at_rest -> probe -> wind ->
slip -> metrics.
"""
