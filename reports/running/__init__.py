"""Runs of solvers: what is run, in which process, how long it takes, what is kept."""
