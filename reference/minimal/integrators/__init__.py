"""Integrators of one phase: heyoka's Taylor method and SciPy's DOP853; both return a `Segment`."""
