"""Texts where a formula belongs: of a curve and of a load. What is accepted is worked out, derivatives and all."""

from math import isfinite

from cases import BadValue, Curve, Load

from ..harness import Kind

# What formulas are made of, some of it poison.
ATOMS = (
    "{v}", "{v}", "{v}", "1", "2", "0.5", "1/3", "1e-3", "pi", "0", "1e150", "1e999", "10**9", "nan", "oo", "I", "x1",
    "'{v}'", "{v}.real", "__import__('os')", "lambda: 1", "[1]", "{v}[0]", "1j", "True", "None", "9" * 50, "",
)  # fmt: skip
FUNCTIONS = (
    "sin", "cos", "exp", "log", "sqrt", "tanh", "atan", "asin", "Abs", "sign", "Heaviside", "erf", "gamma", "eval",
    "cosh", "tan", "open", "floor", "Piecewise", "pi",
)  # fmt: skip
OPERATORS = ("+", "-", "*", "/", "**", "*", "+", "^", "//", "%", "<", " if ", ";", ",", "@", ":=")


def formula(chance, v: str, depth: int = 3) -> str:
    """A random text that is often a formula."""
    if depth == 0 or chance.random() < 0.2:
        return (chance.choice(ATOMS[:12]) if chance.random() < 0.9 else chance.choice(ATOMS)).replace("{v}", v)
    if chance.random() < 0.45:
        name = chance.choice(FUNCTIONS[:8]) if chance.random() < 0.9 else chance.choice(FUNCTIONS)
        return f"{name}({formula(chance, v, depth - 1)})"
    sign = chance.choice(OPERATORS[:7]) if chance.random() < 0.95 else chance.choice(OPERATORS)
    return f"({formula(chance, v, depth - 1)}){sign}({formula(chance, v, depth - 1)})"


def curve(x: str, y: str):
    def call():
        made = Curve((x, y), (-1.0, 1.0))
        return made.structure, made.features

    return call


def load(text: str):
    def call():
        made = Load(fx=text)
        values = made.at(0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7)
        if not all(map(isfinite, values)):  # a case that begins there is refused
            raise BadValue("the formula has no value there")
        return values

    return call


def draw(chance):
    if chance.random() < 0.5:
        text = formula(chance, chance.choice(("t", "vx", "x", "theta")))
        return f"load {text}", load(text)
    text = formula(chance, "s")
    return f"curve s, {text}", curve("s", text)


POISON = (
    "9**(s-s+10**9)", "9**9**9", "sin(" * 60 + "s" + ")" * 60, "(" * 5000 + "s" + ")" * 5000,
    "+".join(["sin(s)"] * 5000),
    "__import__('os').system('false')", "s.__class__", "s if s else 1", "10**-400*s", "1e999", "-" * 3000 + "s",
    "*".join(f"sin({i}*s+0.{i})" for i in range(1, 21)), "((1+s)**64)**64", "2**s", "s**s", "(-1)**0.5*s", "1/0*s",
    "s/0", "0**-1+s", "Abs(s)", "erf(s)", "s**1e9", "s**(1/3)", "cos(s, s)", "cos", "pi(s)", "sqrt(s**2)", "1_000.0*s",
    "\u0455", "s\0", "9" * 4000, "log(s)", "(2+s)**(2/3)/3", "exp(s/3)*2**(1/7)",
    "log(0.5)**s", "(-2)**(1/3)*s", "asin(2)*s",
)  # fmt: skip
FOUND = tuple((f"curve s, {text[:60]}", curve("s", text)) for text in POISON) + tuple(
    (f"load {text[:60]}", load(text.replace("s/", "t/").replace("(s", "(t"))) for text in POISON
)
KIND = Kind("formulas", draw, 500, 40, FOUND)
