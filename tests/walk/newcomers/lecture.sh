# A lecturer: a disc in a circle, then a block on an incline that becomes a curve: a film, a figure and a table.
slip-to-roll cases film disc_in_circle mu=0.2 --out disc.gif  # first result
slip-to-roll cases new slide
sed -i -e 's/Curve, //; s/case, disc/block, case/; s/depth=0.3, mu=0.1, xi1=-1.0/angle=0.5, mu=0.2, xi1=0.0/' -e 's/^from cases.curves.*/from cases.constructions import natural, piecewise/' slide.py
sed -i -e 's/^    return Case/    incline = natural(lambda s: 0, 1.5, angle=-angle)\n    curve = natural(lambda s: 1, 1.5, incline.point(1.5), -angle)\n&/' -e 's/track=.*/track=piecewise([incline, curve]),/; s/plate=disc.*/plate=block(0.2, 0.1, mass=1.0),/' slide.py
slip-to-roll cases check slide.py
slip-to-roll cases show slide.py mu=0.3 --out slide.pdf
slip-to-roll cases film slide.py mu=0.3
slip-to-roll cases export slide.py mu=0.3
python -c 'import pandas as pd; print(pd.read_csv("slide/motion.csv").loc[::1000, ["t", "x", "y", "vx", "normal_force"]].round(4).to_string(index=False))'
