"""Readers of files: what was given, limits for files that nobody vouches for, one file per format."""
