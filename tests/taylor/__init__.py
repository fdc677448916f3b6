"""Tests in which the default method integrates where none is named: of compiled equations, last bits, the catalogue."""
