"""`python -m reference` rebuilds the kept truth of the catalogue."""

from .certification import main

main()
