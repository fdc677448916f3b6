"""Which coordinates to integrate."""
