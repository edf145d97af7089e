"""Session folders: Parquet tables, session.json, event and joint tables, and recordings for other tools."""
