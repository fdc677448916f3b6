"""`python -m reference` rebuilds the stored truth of the catalogue."""

import sys

from .certification.rebuild import main

if __name__ == "__main__":
    sys.exit(main())
