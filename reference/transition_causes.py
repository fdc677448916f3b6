"""What ends a phase, in the words of its transition."""

from __future__ import annotations

# Guards whose zero changes the mode, with the cause that the transition reports.
CAUSES = {
    "slip": "the slip velocity vanished",
    "turn": "the rotation vanished",
    "cone_forward": "friction reached its cone",
    "cone_backward": "friction reached its cone",
    "couple_forward": "rolling resistance reached its bound",
    "couple_backward": "rolling resistance reached its bound",
    "normal_force": "the normal force vanished",
    "piece": "the contact passed to the next piece of its curve",
    "landing": "impact",
    "rest": "bouncing came to rest",
    **dict.fromkeys(("track_start", "track_end", "outline_start", "outline_end"), "the curvature jumped at a knot"),
}
