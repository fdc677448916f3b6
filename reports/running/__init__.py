"""Runs of solvers: the calls, their processes, timing, and the store of results."""
