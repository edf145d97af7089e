"""What commands share: flags and options, exit codes, progress, tables."""
