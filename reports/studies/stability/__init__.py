"""Hard scenes."""
