"""One file per family of cases; importing `cases` finds them all."""
