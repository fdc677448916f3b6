"""Processes that run calls: workers of this machine and of a cluster."""
