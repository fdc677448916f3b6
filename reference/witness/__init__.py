"""The second formulation: numbers in the contacts' own frames. It shares no code with the first.

One contact is integrated in its frame (`second_formulation`). With several contacts and plates accelerations come from
the Delassus matrix with curvatures only, decisions and impacts from linear complementarity problems (Lemke's method)
without enumeration of modes. Both are SciPy's DOP853.
"""

from .prediction import Prediction, predict
from .second_formulation import MOTION, STOPS, SecondMotion, solve

__all__ = ["MOTION", "STOPS", "Prediction", "SecondMotion", "predict", "solve"]
