"""Reports of studies, sessions, reproductions and characterisations as HTML pages, each one file."""
