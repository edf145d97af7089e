"""Sessions on disk: tables, the summary, and recordings for viewers."""
