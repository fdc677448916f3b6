"""The report for readers: the page, its texts and tables, and the folder that holds them."""
