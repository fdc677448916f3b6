"""Timing: CPU times of runs, cold starts, and the breakdown of a run's time."""
