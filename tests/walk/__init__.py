"""What is installed, and every command of the pages with it."""
