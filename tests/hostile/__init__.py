"""Every public callable, with every argument replaced by values that nobody should give, and what comes of it."""
