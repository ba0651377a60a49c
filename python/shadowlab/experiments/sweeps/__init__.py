"""Sweeps: many techniques in many views as one table, in this process, in others, or on a cluster."""
