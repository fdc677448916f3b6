"""A foot on measured ground, with friction by Stribeck's law."""

from cases import Case, CoulombFriction, Curve, Flight, Gravity, Impact, Plate, Start, Unilateral, case

SOLE = [(-0.12, -0.02), (-0.06, -0.05), (0.06, -0.05), (0.12, -0.02), (0.06, 0.06), (-0.06, 0.06)]  # m


@case
def foot(stick=0.6, stribeck=0.1):
    """A foot with six corners slides down 400 measured points of ground, or sticks.

    Why: friction falls from `stick` to 0.2 within the slip speed `stribeck` (m/s). Source: my measurement.
    """
    return Case(
        track=Curve.spline("ground.csv", smoothing=0.004),
        plate=Plate.polygon(SOLE, mass=2.0),
        effects=(
            Gravity(9.81),
            CoulombFriction(f"0.2 + {stick - 0.2}*exp(-(v/{stribeck})**2)"),
            Unilateral(),
            Flight(),
            Impact(0.0, "moreau"),
        ),
        start=Start(xi1=1.0, xi2=0.18, slip=0.3),
        duration=0.3,
    )
