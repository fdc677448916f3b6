"""A check of motions by the laws of mechanics: it computes no motion, and needs none but the one that it checks.

`automatic_check` is what every motion of the reference gets, `full_check` what is asked for; the first does not import
the second.
"""
