"""Which coordinates to integrate: a study."""
