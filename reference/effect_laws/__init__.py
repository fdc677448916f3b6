"""The laws of effects: what each contributes to the equations, its modes, conditions and numbers, also of an impact.

Each effect has one file. An absent one is an object without symbols and conditions, so that no equation tests which
effects there are, and an effect costs nothing in cases without it. `scene_laws` puts the effects of a case together.
The file of an effect is all that has to be written for it: equations of one contact (`minimal`) and of several
(`solver`) ask the objects.
"""

from .scene_laws import Laws, laws

__all__ = ["Laws", "laws"]
