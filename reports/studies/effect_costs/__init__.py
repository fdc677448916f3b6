"""What each effect costs."""
