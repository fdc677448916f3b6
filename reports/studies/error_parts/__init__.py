"""The parts of an error: a study."""
