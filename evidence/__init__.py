"""Pages of evidence: what is measured, its data and figures, and docs/*.md from them and from templates."""
