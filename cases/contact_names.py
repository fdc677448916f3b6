"""The names of a case's first plate and of its contact with its track."""

FIRST = "plate"
# Further contacts with the track are numbered from 2.
CONTACT = f"{FIRST}/track"
