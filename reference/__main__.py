"""`python -m reference` rebuilds the kept truth of the catalogue."""

import sys

from .rebuild import main

if __name__ == "__main__":
    sys.exit(main())
