"""Several balance ropes that differ, in one hoist: definition -> wind -> table."""
