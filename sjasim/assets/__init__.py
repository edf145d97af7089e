"""Names, presets and models that ship with sjasim."""
