"""The cost of the reference: warm, from a cold start, and for longer motions: a study."""
