"""A motion against the truth, and by itself: pure functions of cases and trajectories."""
