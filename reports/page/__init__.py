"""What people read: the page, its texts and tables, the folder they stand in."""
