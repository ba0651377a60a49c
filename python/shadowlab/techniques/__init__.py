"""Techniques by name: the registry, presets of engines, and labels of what stands for a technique in arguments."""
