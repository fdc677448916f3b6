"""First zero of the slip velocity of a disc r = 0.1 m inside a circle R = 1 m, released at rest at ξ₁ = 0.

Source: the quadrature of du/dξ₁ + 2μu = (2g/L)(cos ξ₁ − μ sin ξ₁), u = ξ̇₁², which follows from (35) of Ogaru & Pandrea,
evaluated with 40 digits for L = 0.9 m, g = 9.81 m/s²; `test_closed_form` repeats the evaluation independently.
"""

from cases import Mode

# μ₀ -> (time in s, ξ₁ in rad, what follows)
FIRST_TRANSITION = {
    0.01: (1.0854336058486487598, 3.0783430679172194014, Mode.SLIP_BACKWARD),
    0.1: (0.80999527777318536126, 2.3242002914662824354, Mode.SLIP_BACKWARD),
    0.2: (0.63005376392730307737, 1.6026592443438272745, Mode.ROLL),
}

# μ₀ = 0.2: the whole sequence within 2.5 s, to six digits, from an independent event-driven solve.
SEQUENCE = [
    (0.630054, Mode.ROLL),
    (0.896867, Mode.SLIP_BACKWARD),
    (1.914827, Mode.ROLL),
    (2.107171, Mode.SLIP_FORWARD),
]
