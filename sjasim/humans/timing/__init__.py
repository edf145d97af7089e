"""When people move."""
