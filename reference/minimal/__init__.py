"""The first formulation: the paper's equations in minimal coordinates (ξ₁, ξ₂), event-driven.

frames, elimination, effects, system, assembly and modes define the equations of a mode; decision and impact determine
what follows an event, contact_end applies this; `solver.contact_chart` runs phase after phase, with an integrator of
`integrators`. Flights are in poses (`solver.pose_chart`).
"""
