"""What the reference costs: hot, cold, and as a motion grows."""
