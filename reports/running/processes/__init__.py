"""Processes in which calls run: workers of this machine, and a cluster's."""
