# A paper: 100,000 scenarios, figures as wide as a column, tables in LaTeX, a comparison of engines, and the citation.
slip-to-roll sweep disc_in_circle --vary mu=0.01:0.5:400 --vary xi1=0:1.5:250 --paper  # first result
python table.py
slip-to-roll report --quick --case "disc_in_circle[mu=0.2]" --paper
ls report/figures/*.pdf
python -c 'import pandas as pd; print(pd.read_csv("report/tables/verdict.csv")[["solver", "route", "default_off", "finest_off"]].to_latex(index=False, escape=True, float_format="%.2g"))'
slip-to-roll cases show "disc_in_circle[mu=0.2]" --engines --out disc.pdf
slip-to-roll cite
