"""What carries one phase to its end: heyoka's Taylor method and SciPy's DOP853, with one answer, a segment."""
