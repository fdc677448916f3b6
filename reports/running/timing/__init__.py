"""The clock: CPU times of runs, cold starts, and how a run's time divides."""
