"""The share of each outcome among the scenarios of a sweep, as a LaTeX table."""

import pandas as pd

rows = pd.read_parquet("sweep/rows")
shares = rows["sequence"].value_counts(normalize=True).head(6).rename("share")
shares.rename_axis("motion").reset_index().style.hide().format({"share": r"\num{{{:.3f}}}"}).to_latex(
    "outcomes.tex", caption="Outcomes of 100,000 scenarios.", label="tab:outcomes", hrules=True
)
print(f"{len(rows)} rows; outcomes.tex")
