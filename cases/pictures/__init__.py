"""Cases and motions as pictures: for papers, slides and notebooks.

Nobody imports this at the top of a module: Matplotlib takes half a second, and whoever computes does not draw. Nothing
here decides an answer, so what is kept of answers does not depend on its code. It knows curves and numbers, and takes
for a motion whatever has times `t`, states at times, `transitions` and `first_mode`.
"""

# Stands in every picture that a command writes, so that the next one knows it for its own.
MADE_BY = "slip-to-roll"
