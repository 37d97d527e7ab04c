"""A run and a study for readers: summary table, figures, Markdown and HTML."""
