"""The parts of an error."""
