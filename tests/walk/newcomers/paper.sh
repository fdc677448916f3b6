# A paper: 100,000 scenarios, figures as wide as a column, tables in LaTeX, a comparison of engines, and the citation.
slip-to-roll sweep disc_in_circle --vary mu=0.01:0.5:400 --vary xi1=0:1.5:250 --paper  # first result
python table.py
slip-to-roll report --quick --case "disc_in_circle[mu=0.2]" --paper
ls report/figures/*.pdf report/tables/verdict.tex
cat report/tables/verdict.tex
slip-to-roll cite
