"""What command-line faces share: options, progress, result tables."""
