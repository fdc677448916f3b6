"""`python -m tests.fuzz KIND NUMBER [SEED]`: one input again, with its traceback; without words the kinds."""

import sys

from .harness import kinds, seed, trial

if len(sys.argv) < 3:
    print("\n".join(f"{kind.name}: {kind.whole} drawn, {len(kind.found) + len(kind.long)} kept" for kind in kinds()))
else:
    kind = next(kind for kind in kinds() if kind.name == sys.argv[1])
    words, call = trial(kind, int(sys.argv[2]), int(sys.argv[3]) if len(sys.argv) > 3 else seed())
    print(words)
    print(call())
