"""The names of a case's first plate, of its track among the supports, and of the contact of both."""

FIRST, TRACK = "plate", "track"
# Further contacts with the track are numbered from 2.
CONTACT = f"{FIRST}/{TRACK}"
