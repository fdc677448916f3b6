"""Maps of the paper's application over friction and start, and where engines are wrong: a study."""
