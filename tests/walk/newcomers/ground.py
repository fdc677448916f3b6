"""400 measured points of a ground: a valley of 30 cm with waves, and errors of 1 mm; header x,y, in metres."""

import numpy as np

x = np.linspace(-3.0, 3.0, 400)
y = 0.06 * x**2 + 0.01 * np.sin(5 * x) + np.random.default_rng(1).normal(0.0, 1e-3, x.size)
np.savetxt("ground.csv", np.column_stack([x, y]), delimiter=",", header="x,y", comments="", fmt="%.4f")
