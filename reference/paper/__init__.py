"""The paper's equations, literally: its kinematics (1)–(14) and its augmented system (15)–(34), as printed.

Nothing here uses the eliminated equations or the event loop; `reference.augmented_integrator` integrates this system.
"""
