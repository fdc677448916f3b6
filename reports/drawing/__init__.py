"""Records and rows -> figures."""
