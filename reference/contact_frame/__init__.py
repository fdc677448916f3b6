"""The second formulation: numbers in the contact's own frame. It shares no code with the first."""

from .second_formulation import MOTION, STOPS, SecondMotion, solve

__all__ = ["MOTION", "STOPS", "SecondMotion", "solve"]
