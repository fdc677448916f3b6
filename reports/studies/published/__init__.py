"""Published numbers: a study."""
