"""Results as words, files and pages."""
