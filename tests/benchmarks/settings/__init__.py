"""Whether every rung of a ladder is worth its cost: a study."""
