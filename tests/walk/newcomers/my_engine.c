/* A disc on a level line with regularised friction, as many engines have it: the contact creeps while it sticks. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char scene[1 << 22];

static double value(const char *name) { /* the first number of that name in the scene; 0 if there is none */
    char key[40];
    snprintf(key, sizeof key, "\"%s\":", name);
    const char *found = strstr(scene, key);
    return found ? strtod(found + strlen(key), NULL) : 0.0;
}

int main(void) {
    scene[fread(scene, 1, sizeof scene - 1, stdin)] = 0;
    const char *absent[] = {"RollingResistance", "Flight"};
    int refused = !strstr(scene, "\"track\": [\"s\", \"0\"]") || value("mu_static");
    for (size_t i = 0; i < sizeof absent / sizeof *absent; i++) refused |= strstr(scene, absent[i]) != NULL;
    if (refused) {
        fprintf(stderr, "Only discs that slide and roll on a level line are supported.\n");
        return 3;
    }
    double m = value("mass"), J = value("inertia"), r = value("radius"), mu = value("mu"), g = value("g");
    double x = value("x"), y = value("y"), theta = value("theta"), v = value("vx"), omega = value("omega");
    int samples = (int)ceil(value("duration") / value("h")), substeps = 100;
    double h = value("duration") / samples / substeps, soft = 2e-3; /* m/s: friction grows to mu N over this slip velocity */
    puts("t,x,y,theta,vx,vy,omega");
    for (int k = 0; k <= samples; k++) {
        printf("%.12g,%.12g,%.12g,%.12g,%.12g,0,%.12g\n", k * h * substeps, x, y, theta, v, omega);
        for (int i = 0; i < substeps; i++) {
            double friction = -mu * m * g * tanh((v + r * omega) / soft);
            v += h * friction / m, omega += h * r * friction / J, x += h * v, theta += h * omega;
        }
    }
    return 0;
}
