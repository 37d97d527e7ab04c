"""A run and a study for readers: verdict, figures, tables, Markdown and HTML."""
