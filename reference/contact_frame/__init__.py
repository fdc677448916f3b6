"""The second formulation: numbers in the contact's own frame. It shares no code with the first."""

from .march import MOTION, STOPS, Answer, solve

__all__ = ["MOTION", "STOPS", "Answer", "solve"]
