"""The reference's name among the solvers; imports nothing slow."""

REFERENCE = "reference"
