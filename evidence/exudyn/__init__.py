"""The rope in an independent multibody code, Exudyn, beside ours."""

import sys

# Exudyn reads it at its import: the build without range checks
sys.exudynFast = True  # type: ignore[attr-defined]
