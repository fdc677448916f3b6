"""The meaning of the engines' parameters: `study` makes a table, `__main__` a page."""
