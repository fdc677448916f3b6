# A paper: figures as PDF, a table in LaTeX, one case with all engines, and the citation.
slip-to-roll report --quick --case "disc_in_circle[mu=0.2]" --paper  # first result
ls report/figures/*.pdf
python -c 'import pandas as pd; print(pd.read_csv("report/tables/verdict.csv")[["solver", "route", "default_off", "finest_off"]].to_latex(index=False, escape=True, float_format="%.2g"))'
slip-to-roll cases show "disc_in_circle[mu=0.2]" --engines --out disc.pdf
slip-to-roll release cite
