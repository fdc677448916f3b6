# A PhD student: a foot on 400 measured points of ground with Stribeck's law; one motion, then a sweep of two parameters.
python ground.py
slip-to-roll cases check foot.py  # first result
slip-to-roll cases show foot.py stribeck=0.05
slip-to-roll sweep foot.py --vary stick=0.4:0.8:6 --vary stribeck=0.02:0.2:6
python -c 'import pandas as pd; rows = pd.read_parquet("sweep/rows"); print(len(rows), "rows;", rows["first_time"].round(4).max(), "s")'
ls sweep
