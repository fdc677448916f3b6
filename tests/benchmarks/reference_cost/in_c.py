"""The paper's application in plain C: the lowest cost of the end of the first slip phase on this machine.

With w = ξ̇² (35) is linear in ξ: w' + 2μ w = (2g/L) (cos ξ - μ sin ξ), so that w, the time and the slip are integrals of
elementary functions; ξ = s² removes the square-root singularity at the start. Newton's method on the slip, with bounds.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import numpy as np

SOURCE = """
#include <math.h>

static double w(double xi, double mu, double g, double L) {
    double d = 1 + 4 * mu * mu;
    return 2 * g / L * ((1 - 2 * mu * mu) / d * sin(xi) + 3 * mu / d * (cos(xi) - exp(-2 * mu * xi)));
}

/* When v = 0 follows a release at xi = 0; x, c: Gauss-Legendre nodes and weights on (0, 1). */
double first_slip(double mu, double g, double L, int n, const double *x, const double *c) {
    double s = 1.2, low = 0, high = 1.78, time = 0; /* not beyond xi = pi */
    for (int i = 0; i < 100; i++) {
        double impulse = 0;
        time = 0;
        for (int k = 0; k < n; k++) {
            double xi = s * x[k] * s * x[k], v2 = w(xi, mu, g, L), dt = c[k] * s * 2 * s * x[k] / sqrt(v2);
            time += dt;
            impulse += dt * (g * sin(xi) + L * v2);
        }
        double xi = s * s, v2 = w(xi, mu, g, L), v = sqrt(v2);
        double normal = g * sin(xi) + L * v2;
        double slip = L * v - 2 * mu * impulse;
        /* L dv/dt by (35), and the friction's share; per s by dt = 2 s ds / v. */
        double rate = g * (cos(xi) - mu * sin(xi)) - mu * L * v2 - 2 * mu * normal;
        double step = slip / (rate * 2 * s / v);
        if (fabs(step) < 1e-11 * s) break;
        if (slip > 0) low = s; else high = s; /* also where there is no motion any more, and no number */
        s = s - step > low && s - step < high ? s - step : (low + high) / 2;
    }
    return time;
}
"""


@lru_cache(maxsize=1)
def library() -> ctypes.CDLL | None:
    """The compiled function; None without a C compiler."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        source, shared_object = Path(folder) / "first_slip.c", Path(folder) / "first_slip.so"
        source.write_text(SOURCE)
        command = [compiler, "-O3", "-march=native", "-shared", "-fPIC", str(source), "-o", str(shared_object), "-lm"]
        if subprocess.run(command, capture_output=True).returncode:
            return None
        library = ctypes.CDLL(str(shared_object))
    library.first_slip.restype = ctypes.c_double
    pointer = ctypes.POINTER(ctypes.c_double)
    library.first_slip.argtypes = [*[ctypes.c_double] * 3, ctypes.c_int, pointer, pointer]
    return library


def first_slip(mu: float, nodes: int) -> Callable[[], float] | None:
    """A function that returns the time (s) at which the slip of the paper's disc (R = 1 m, r = 0.1 m) vanishes, by a
    quadrature with `nodes` nodes; None without a C compiler."""
    compiled_library = library()
    if compiled_library is None:
        return None
    places, weights = np.polynomial.legendre.leggauss(nodes)
    x, c = 0.5 * (places + 1.0), 0.5 * weights
    nodes_of_c, weights_of_c = (np.ctypeslib.as_ctypes(np.ascontiguousarray(part)) for part in (x, c))

    def solve() -> float:
        return compiled_library.first_slip(mu, 9.81, 0.9, nodes, nodes_of_c, weights_of_c)

    return solve
