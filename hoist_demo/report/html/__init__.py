"""Reports as single HTML files: a run with its rope in motion, and a study of many runs.

run and study choose what is shown; packing makes numbers small, and pictures of what was recorded
along the rope; page joins text, data and the files of assets/. The files of assets/ are plain CSS
and JavaScript without a library: all pictures are SVG that the browser draws from the packed
numbers, so a page needs no network and prints as it is.
"""
