"""Measurements of the suite itself, for its maintainers; no command of the suite runs them."""
