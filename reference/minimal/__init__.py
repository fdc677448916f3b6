"""The first formulation: the paper's equations in minimal coordinates (ξ₁, ξ₂), event-driven.

frames, eliminated, effects, system, modes say what a mode's equations are; decision, impact, landing, bouncing, overlap
what follows an event; hybrid goes from phase to phase, with an integrator of `integrators`.
"""
