"""Whether every rung of a ladder pays: a study; `study` says how."""
