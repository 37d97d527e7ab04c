"""Many trips as one run: schedule -> wind -> table."""
