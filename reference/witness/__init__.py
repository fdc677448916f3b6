"""The second formulation: numbers in the contacts' own frames. It shares no equations with the first.

Accelerations come from the Delassus matrix with curvatures only, decisions and impacts from linear complementarity
problems (Lemke's method) without enumeration of modes, and steps are those of SciPy's DOP853. One contact, several
contacts and several plates are one simulation.
"""

from .prediction import Prediction, predict

__all__ = ["Prediction", "predict"]
