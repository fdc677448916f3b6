"""`slip-to-roll submit FOLDER`: an older name of `reports.compare FOLDER`, for one version."""

import sys

from .compare import main

if __name__ == "__main__":
    sys.exit(main())
