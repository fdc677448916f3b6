"""What the engines' parameters mean; `study` has it as a table, `__main__` as a page."""
