"""Pictures of cases and motions for papers, slides and notebooks.

Import this package inside functions, not at the top of a module: importing Matplotlib takes half a second, which
computations without pictures should not pay. No answer depends on this package, so cache keys of answers do not include
its code. It uses only curves and numbers; a motion is any object with times `t`, states at times, `transitions` and
`first_mode`.
"""

# Written into every picture that a command makes, so that later commands recognise the file as theirs.
MADE_BY = "slip-to-roll"
