"""The first formulation: the paper's equations in minimal coordinates (ξ₁, ξ₂), event-driven.

frames, elimination, effects, system, assembly and modes define the equations of a mode; decision, impact, landing,
bouncing determine what follows an event, contact_end and flight_end apply this; `solver.contact_chart` runs phase after
phase, with an integrator of `integrators`.
"""
