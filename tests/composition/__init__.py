"""Scenes drawn over all features at once, for any build of the suite: what composes, and what does not."""
