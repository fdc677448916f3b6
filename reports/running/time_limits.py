"""Time limits of calls, in wall seconds: of a run by effort, of any call, and of short questions to a solver."""

from __future__ import annotations

# Of a run, by the effort of the report. A whole default report takes a few minutes on two cores.
RUN_SECONDS = {"quick": 20.0, "default": 60.0, "full": 600.0}
# Of a call, unless it has another. A whole default report takes minutes, so a longer run is a failure.
LIMIT_SECONDS = 60.0
# Of asking a solver for its version or its settings for a case: these take milliseconds, imports a few seconds.
ASKING_SECONDS = 20.0
