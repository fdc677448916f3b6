"""Formulas of authors as expressions, as graphs and as code."""
