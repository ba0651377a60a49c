"""Rows of runs in one file: kept as they finish, found again by their content, read back as a table."""
