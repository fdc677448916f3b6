"""Records of runs -> rows of tables."""
