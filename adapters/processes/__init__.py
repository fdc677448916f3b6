"""Calls in processes of their own: a pool of workers, and what a worker does."""
