"""Sweeps: one case with many parameters, in parts that any machine can do by itself, and their maps."""
