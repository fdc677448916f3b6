"""The form of a motion, and what follows from it and its case."""
