"""Three motions with 22 digits, which certificates are held against.

Computed here (`computed`) by mpmath's Taylor integration with 24 digits, from equations of one degree of freedom that
share nothing with the suite's: a pendulum of length R − r for the disc that slides round a loop, and for plates of
support function h that roll on a line, with ψ = −π/2 − θ the direction of the normal to the contact,

    M(ψ) ω̇ = ½ M′ ω² + m g h′,    M = J + m (h² + h′²),    ẋ = −h ω,    y = h

(the energy ½ M ω² + m g h, differentiated). The numbers of the cases are taken as the doubles they are. Rolling holds
throughout: friction stays inside its cone, as the suite's transitions say. Making all of it again takes four minutes.
"""

from __future__ import annotations

import mpmath
from mpmath import atan2, cos, mpf, odefun, pi, sin, sqrt

import cases

LOOP, ELLIPSE, TRIANGLE = "sliding_loop[ratio=5.1]", "ellipse_on_line[mu=1]", "rounded_triangle_on_line"
QUANTITIES = ("x", "y", "theta", "slip", "omega")
DIGITS = 24
GRAVITY = mpf(9.81)


def computed(label: str, times) -> dict[str, list]:
    """The motion of one of the three cases at the times (s), by quantity."""
    case = cases.load(label)
    with mpmath.workdps(DIGITS):
        at = {LOOP: _loop, ELLIPSE: _ellipse, TRIANGLE: _triangle}[label](case)
        rows = [at(mpf(float(t))) for t in times]
    return {quantity: list(column) for quantity, column in zip(QUANTITIES, zip(*rows, strict=True), strict=True)}


def _loop(case):
    length = mpf(1) - mpf(0.1)
    start = [mpf(case.start.xi1), mpf(case.start.slip) / length]
    swing = odefun(lambda t, y: [y[1], -GRAVITY * cos(y[0]) / length], mpf(0), start)

    def at(t):
        angle, rate = swing(t)
        return length * cos(angle), length * sin(angle), mpf(0), length * rate, mpf(0)

    return at


def _ellipse(case):
    a, b, s = mpf(0.3), mpf(0.2), mpf(case.start.xi2)

    def h(p):
        return sqrt(a**2 * cos(p) ** 2 + b**2 * sin(p) ** 2)

    def h1(p):
        return (b**2 - a**2) * sin(p) * cos(p) / h(p)

    def h2(p):
        return ((b**2 - a**2) * cos(2 * p) - h1(p) ** 2) / h(p)

    return _rolling(case, h, h1, h2, atan2(a * sin(s), b * cos(s)))


def _triangle(case):
    r, swell = mpf(0.1), mpf(0.1 * 0.8 / 8)

    def h(p):
        return r + swell * cos(3 * p)

    def h1(p):
        return -3 * swell * sin(3 * p)

    def h2(p):
        return -9 * swell * cos(3 * p)

    return _rolling(case, h, h1, h2, mpf(case.start.xi2))


def _rolling(case, h, h1, h2, psi):
    """A plate on a line, its contact at first at x = 0 below the point of the outline whose normal has that angle."""
    m, J = mpf(case.plate.mass), mpf(case.plate.inertia)

    def rates(t, y):
        theta, omega, _ = y
        p = -pi / 2 - theta
        M, half_slope = J + m * (h(p) ** 2 + h1(p) ** 2), m * h1(p) * (h(p) + h2(p))
        return [omega, (half_slope * omega**2 + m * GRAVITY * h1(p)) / M, -omega * h(p)]

    roll = odefun(rates, mpf(0), [-pi / 2 - psi, mpf(case.start.omega), -h1(psi)])

    def at(t):
        theta, omega, x = roll(t)
        return x, h(-pi / 2 - theta), theta, mpf(0), omega

    return at


# Sample times, s, as a certificate has them: eleven from beginning to end.
TIMES = {
    LOOP: [0.0, 0.15, 0.3, 0.44999999999999996, 0.6, 0.75, 0.8999999999999999, 1.05, 1.2, 1.3499999999999999, 1.5],
    ELLIPSE: [0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0, 1.2000000000000002, 1.4000000000000001, 1.6, 1.8, 2.0],
    TRIANGLE: [0.0, 0.12, 0.24, 0.36, 0.48, 0.6, 0.72, 0.84, 0.96, 1.08, 1.2],
}

# As `computed` gives them, by quantity.
STATES: dict[str, dict[str, list[str]]] = {
    LOOP: {
        "x": [
            "5.510910596163089263527e-17",
            "0.7919887765639269346063",
            "0.8345257473937824453465",
            "0.4520686788096625688184",
            "-0.01152575029833771906444",
            "-0.4742470261000508933754",
            "-0.846641639952984017648",
            "-0.7699100054966760262465",
            "0.04960503193939700775744",
            "0.8119311092231238521889",
            "0.8214259107548397483632",
        ],
        "y": [
            "-0.8999999999999999944489",
            "-0.4274971085244603245718",
            "0.3369967016705783756125",
            "0.7782248451696245678844",
            "0.89992619535163013166",
            "0.7649116015823381644561",
            "0.3052833659040756953753",
            "-0.4660886004142434302062",
            "-0.8986319273241360818233",
            "-0.3882883900861674172729",
            "0.3677763901347964927998",
        ],
        "theta": ["0"] * 11,
        "slip": [
            "6.710283153489128515901",
            "5.979748595823231956489",
            "4.556097531135967049484",
            "3.478667638302338234265",
            "3.116624463614604021176",
            "3.516011145738097166866",
            "4.623877200030515176281",
            "6.042727723481131568745",
            "6.708282821564662767119",
            "5.915075503617059275298",
            "4.489334831080802191682",
        ],
        "omega": ["0"] * 11,
    },
    ELLIPSE: {
        "x": [
            "-0.08562200171578903231102",
            "-0.1257069257976606957167",
            "-0.2145020526163383482445",
            "-0.262427329092355180179",
            "-0.2304643336850604927017",
            "-0.1428657145122664856632",
            "-0.08746414544554559855762",
            "-0.1110947135304976638086",
            "-0.1963347870777963052956",
            "-0.2587525386593800469809",
            "-0.2436025108836212921819",
        ],
        "y": [
            "0.2204765950396199838911",
            "0.2069382320485066681068",
            "0.204855417380939114109",
            "0.2202976982261841634841",
            "0.2091241306617324120108",
            "0.2030010903647302374626",
            "0.2197641279185129180005",
            "0.2113007472731820701077",
            "0.2015040534788949107469",
            "0.2188855593732281305455",
            "0.213373333454770164925",
        ],
        "theta": [
            "-0.4279078145138901044812",
            "-0.2399265758896846463462",
            "0.1996024635932137138963",
            "0.4258154760798970262451",
            "0.2767556877473157245952",
            "-0.1561615932890869619821",
            "-0.4195389864200663857506",
            "-0.3098267228041043069985",
            "0.1101208899669712130959",
            "0.4090806056234796517376",
            "0.3389648649953697377187",
        ],
        "slip": ["0"] * 11,
        "omega": [
            "0.0",
            "1.84026660119850298924",
            "1.998776062126392967142",
            "0.1993514919051708919423",
            "-1.66669380677452165277",
            "-2.136115731042871529195",
            "-0.3986475458336812020301",
            "1.482900682764649510515",
            "2.245281182420434932665",
            "0.5977669430210164759653",
            "-1.292475290770321922091",
        ],
    },
    TRIANGLE: {
        "x": [
            "0.01864829904811992987005",
            "0.1047613023145364274303",
            "0.179926755270431313288",
            "0.2656615456671580687351",
            "0.3456859351540636469345",
            "0.4230745973184167915664",
            "0.5104536374257234859251",
            "0.5860903232073464917797",
            "0.6695173219738282231239",
            "0.752162678902320026958",
            "0.8280907529194413126478",
        ],
        "y": [
            "0.09216673090372516817455",
            "0.1047247160552347693454",
            "0.1053712171804994958038",
            "0.09159598788288915553808",
            "0.1097962682148427566121",
            "0.09575852771644254424376",
            "0.1010756910449122946395",
            "0.1079824031119539235476",
            "0.09002842262296866413923",
            "0.1085631381373440010861",
            "0.09987298891029264029082",
        ],
        "theta": [
            "-0.3000000000000001056413",
            "-1.211228561351744618649",
            "-1.905388069563483013732",
            "-2.808918290535960407258",
            "-3.597790910626408531304",
            "-4.334796873418135124758",
            "-5.271913636385547768443",
            "-5.975062603475211043649",
            "-6.831921967986615388166",
            "-7.673079326056768510923",
            "-8.381814226400160610196",
        ],
        "slip": ["0"] * 11,
        "omega": [
            "-8.0",
            "-6.194555157154168464075",
            "-6.11868301063653103392",
            "-8.105717422828821903999",
            "-5.621045651704791777702",
            "-7.395903555722025702273",
            "-6.644777081819469038102",
            "-5.821178086871543439926",
            "-8.412765979019455234536",
            "-5.756624667345795392376",
            "-6.803174751426813052458",
        ],
    },
}
