# A paper: 100,000 scenarios, a figure as wide as a column, a table in LaTeX, and the citation.
slip-to-roll sweep disc_in_circle --vary mu=0.01:0.5:400 --vary xi1=0:1.5:250 --paper  # first result
python table.py
slip-to-roll cite
