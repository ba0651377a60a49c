"""Matrices from elsewhere: their convention, files of them, and what is wrong with them."""
