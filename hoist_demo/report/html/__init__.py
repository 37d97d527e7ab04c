"""Reports as single HTML files: a run with its rope in motion, and a study of many runs.

run and study choose what is shown; packing makes numbers small, and pictures of stress and tension over length and time;
page joins text, data and the files of assets/. The files of assets/ are plain CSS and JavaScript without a library: all
pictures are SVG that the browser draws from the packed numbers, so a page needs no network and prints as it is.
"""
