"""The cost of each effect: a study."""
