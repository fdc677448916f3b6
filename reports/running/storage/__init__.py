"""Stored results of earlier builds: the store, its keys, and the code and versions in the keys."""
