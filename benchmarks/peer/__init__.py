"""The rope in an independent multibody code, Exudyn, beside ours: ``make peer``."""
