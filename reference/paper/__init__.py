"""The paper, literally: its kinematics (1)–(14) and its augmented system (15)–(34), as they are written.

Nothing here knows the eliminated equations or the event loop; `reference.augmented_integrator` makes an integrator of
it.
"""
