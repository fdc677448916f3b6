/* A complete engine for `--engine`: a disc with Coulomb friction on a line or a circle. Replace `step` by your engine.
   It reads one scene as JSON and writes the motion as CSV (docs/process_protocol.md). SI units, radians.
   cc -O2 -o my_engine engine.c -lm */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct { double x, y, heading, u, theta, omega; } State; /* of the centre: place, direction and speed; angle, rate */
typedef struct { double heading, u, omega, normal, tangential; } Rates;

static double m, J, r, mu, gx, gy, curvature;

/* The text after a key of the JSON text, after the keys before it; "0" if there is none. */
static const char *find(const char *text, const char *first, const char *second, const char *third) {
    const char *keys[] = {first, second, third};
    char key[40];
    for (int i = 0; text && i < 3 && keys[i]; i++) {
        snprintf(key, sizeof key, "\"%s\":", keys[i]);
        if ((text = strstr(text, key))) text += strlen(key);
    }
    return text ? text : "0";
}

static double number(const char *text, const char *first, const char *second) {
    return strtod(find(text, first, second, NULL), NULL);
}

static int is_supported(const char *scene, const char *effects) {
    for (const char *c = effects; c < strstr(effects, "\"start\":"); c++) /* names of effects have capital letters */
        if (*c == '"' && isupper((unsigned char)c[1]) && strncmp(c, "\"Gravity", 8) && strncmp(c, "\"Coulomb", 8)
            && strncmp(c, "\"Unilateral", 11)) return 0;
    const char *bends = strchr(find(scene, "points", "track", "curvature"), '[');
    for (char *end = (char *)bends; *end != ']';)
        if (fabs(strtod(end + 1, &end) - curvature) > 1e-9 * fabs(curvature)) return 0;
    if (strchr("\"n", find(effects, "mu", NULL, NULL)[1])) return 0; /* a formula */
    return r > 0 && number(effects, "mu_static", NULL) == 0 && strncmp(find(scene, "start", "xi1", NULL), " null", 5);
}

static State read_scene(const char *scene, const char *effects) {
    const char *track = find(scene, "points", "track", NULL), *start = find(scene, "start", NULL, NULL);
    double first[5], x = number(start, "x", NULL), y = number(start, "y", NULL);
    const char *names[] = {"x", "y", "normal_x", "normal_y", "curvature"};
    for (int i = 0; i < 5; i++) first[i] = strtod(strchr(find(track, names[i], NULL, NULL), '[') + 1, NULL);
    r = number(scene, "plate", "radius"), m = number(scene, "plate", "mass"), J = number(scene, "plate", "inertia");
    if (J == 0) J = INFINITY; /* null: the disc does not turn */
    mu = number(effects, "mu", NULL), curvature = first[4];
    gx = number(effects, "g", NULL) * cos(number(effects, "direction", NULL));
    gy = number(effects, "g", NULL) * sin(number(effects, "direction", NULL));
    double nx = first[2], ny = first[3]; /* the track's left normal; of a circle, from its centre to the disc's */
    if (curvature != 0) nx = (first[0] - x) * curvature + first[2], ny = (first[1] - y) * curvature + first[3];
    double heading = atan2(-nx, ny), tx = cos(heading), ty = sin(heading);
    return (State){x, y, heading, number(start, "vx", NULL) * tx + number(start, "vy", NULL) * ty,
                   number(start, "theta", NULL), number(start, "omega", NULL)};
}

/* Friction is as large as sticking until the end of the step needs, up to mu times the normal force. */
static Rates rates(State from, double heading, double u, double h) {
    double tx = cos(heading), ty = sin(heading), turning = curvature * u / (1 - curvature * r);
    double along = gx * tx + gy * ty, normal = m * (turning * u - (gy * tx - gx * ty)), most = mu * fabs(normal);
    double stop = -((from.u + r * from.omega) / h + along) / (1 / m + r * r / J);
    double tangential = fmax(-most, fmin(most, stop));
    return (Rates){turning, along + tangential / m, r * tangential / J, normal, tangential};
}

static State step(State a, double h, Rates *first) { /* the midpoint rule */
    *first = rates(a, a.heading, a.u, h);
    double heading = a.heading + 0.5 * h * first->heading, u = a.u + 0.5 * h * first->u;
    Rates k = rates(a, heading, u, h);
    return (State){a.x + h * u * cos(heading), a.y + h * u * sin(heading), a.heading + h * k.heading, a.u + h * k.u,
                   a.theta + h * (a.omega + 0.5 * h * k.omega), a.omega + h * k.omega};
}

int main(void) {
    static char scene[1 << 25]; /* --points 100000 writes 25 MB */
    scene[fread(scene, 1, sizeof scene - 1, stdin)] = 0;
    const char *effects = find(scene, "effects", NULL, NULL);
    State a = read_scene(scene, effects);
    if (!is_supported(scene, effects)) {
        fprintf(stderr, "Only discs in contact with a line or a circle, with one coefficient of friction, are supported.\n");
        return 3; /* unsupported; any other status but 0 is a crash */
    }
    double duration = number(scene, "duration", NULL);
    int steps = (int)fmax(60, ceil(duration / number(scene, "setting", "h")));
    /* An engine whose contacts creep while they stick may report the speed: puts("# creep = 5e-3"); */
    puts("t,x,y,theta,vx,vy,omega,normal_force,friction_force");
    for (int k = 0; k <= steps; k++) {
        Rates now;
        State next = step(a, duration / steps, &now);
        if (now.normal < 0 && strstr(effects, "\"Unilateral\"")) break; /* the disc leaves the track: the output ends */
        printf("%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", k * duration / steps, a.x, a.y, a.theta,
               a.u * cos(a.heading), a.u * sin(a.heading), a.omega, now.normal, now.tangential);
        a = next;
    }
    return 0;
}
