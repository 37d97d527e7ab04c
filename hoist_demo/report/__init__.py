"""A run for readers: verdict, figures, tables, plain text and Markdown; the pages are in html.

Nothing here imports html.
"""
