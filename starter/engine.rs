// A complete engine for `--engine`: a disc with Coulomb friction on a line or a circle. Replace `step` by your engine.
// It reads one scene as JSON and writes the motion as CSV (docs/process_protocol.md). SI units, radians.
// rustc -O -o my_engine engine.rs
use std::io::{self, Read, Write};

/// Of the centre: place, direction and speed along the track; angle and its rate.
#[derive(Clone, Copy)]
struct State { x: f64, y: f64, heading: f64, u: f64, theta: f64, omega: f64 }

struct Scene { m: f64, j: f64, r: f64, mu: f64, gx: f64, gy: f64, bend: f64 }

struct Rates { turning: f64, du: f64, domega: f64, normal: f64, tangential: f64 }

/// The text after a key of the JSON text, after the keys before it; "0" if there is none.
fn find<'a>(text: &'a str, keys: &[&str]) -> &'a str {
    keys.iter().try_fold(text, |rest, key| rest.split_once(&format!("\"{key}\":")).map(|(_, after)| after)).unwrap_or("0")
}

/// The number after the keys, or the first of a list; NaN for null.
fn number(text: &str, keys: &[&str]) -> f64 {
    let after = find(text, keys).trim_start_matches([' ', '[']);
    after[..after.find([',', '}', ']']).unwrap_or(after.len())].trim().parse().unwrap_or(f64::NAN)
}

fn is_supported(text: &str, scene: &Scene) -> bool {
    let effects = find(text, &["effects"]).split("\"start\":").next().unwrap_or("");
    // Names of effects begin with a capital letter.
    let mut names = effects.split('"').filter(|part| part.starts_with(|c: char| c.is_ascii_uppercase()));
    let rough = number(effects, &["mu_static"]) > 0.0;
    let bends = find(text, &["points", "track", "curvature"]).trim_start_matches([' ', '[']).split(']').next().unwrap_or("");
    let round = bends.split(',').all(|c| (c.trim().parse().unwrap_or(f64::NAN) - scene.bend).abs() <= 1e-9 * scene.bend.abs());
    scene.r > 0.0 && scene.mu >= 0.0 && !rough && round && number(text, &["start", "xi1"]).is_finite()
        && names.all(|name| ["Gravity", "CoulombFriction", "Unilateral"].contains(&name))
}

fn start(text: &str, bend: f64) -> State {
    let at = |name| number(text, &["start", name]);
    let first = |name| number(text, &["points", "track", name]);
    let (mut nx, mut ny) = (first("normal_x"), first("normal_y"));
    if bend != 0.0 { // the track's left normal; of a circle, along the line from the disc's centre to the circle's
        nx += (first("x") - at("x")) * bend;
        ny += (first("y") - at("y")) * bend;
    }
    let heading = (-nx).atan2(ny);
    let u = at("vx") * heading.cos() + at("vy") * heading.sin();
    State { x: at("x"), y: at("y"), heading, u, theta: at("theta"), omega: at("omega") }
}

/// Friction is as large as sticking until the end of the step needs, up to mu times the normal force.
fn rates(scene: &Scene, from: State, heading: f64, u: f64, h: f64) -> Rates {
    let &Scene { m, j, r, mu, gx, gy, bend } = scene;
    let (tx, ty) = (heading.cos(), heading.sin());
    let (turning, along) = (bend * u / (1.0 - bend * r), gx * tx + gy * ty);
    let normal = m * (turning * u - (gy * tx - gx * ty));
    let stop = -((from.u + r * from.omega) / h + along) / (1.0 / m + r * r / j);
    let tangential = stop.clamp(-mu * normal.abs(), mu * normal.abs());
    Rates { turning, du: along + tangential / m, domega: r * tangential / j, normal, tangential }
}

/// The next state by the midpoint rule, and the rates and forces at this one.
fn step(scene: &Scene, a: State, h: f64) -> (State, Rates) {
    let first = rates(scene, a, a.heading, a.u, h);
    let (heading, u) = (a.heading + 0.5 * h * first.turning, a.u + 0.5 * h * first.du);
    let k = rates(scene, a, heading, u, h);
    let (x, y) = (a.x + h * u * heading.cos(), a.y + h * u * heading.sin());
    let theta = a.theta + h * (a.omega + 0.5 * h * k.domega);
    (State { x, y, heading: a.heading + h * k.turning, u: a.u + h * k.du, theta, omega: a.omega + h * k.domega }, first)
}

fn main() -> io::Result<()> {
    let mut text = String::new();
    io::stdin().read_to_string(&mut text)?;
    let effects = find(&text, &["effects"]);
    let (g, direction) = (number(effects, &["g"]), number(effects, &["direction"]));
    let plate = |name| number(&text, &["plate", name]);
    let (m, j, r, mu) = (plate("mass"), plate("inertia"), plate("radius"), number(effects, &["mu"]));
    let j = if j.is_nan() { f64::INFINITY } else { j }; // null: the disc does not turn
    let bend = number(&text, &["points", "track", "curvature"]);
    let scene = Scene { m, j, r, mu, gx: g * direction.cos(), gy: g * direction.sin(), bend };
    if !is_supported(&text, &scene) {
        eprintln!("Only discs in contact with a line or a circle, with one coefficient of friction, are supported.");
        std::process::exit(3); // unsupported; any other status but 0 is a crash
    }
    let (duration, mut a) = (number(&text, &["duration"]), start(&text, bend));
    let steps = (duration / number(&text, &["setting", "h"])).ceil().max(60.0) as u32;
    let mut out = io::BufWriter::new(io::stdout().lock());
    // An engine whose contacts creep while they stick may report the speed: writeln!(out, "# creep = 5e-3")?;
    writeln!(out, "t,x,y,theta,vx,vy,omega,normal_force,friction_force")?;
    for k in 0..=steps {
        let (t, (next, now)) = (f64::from(k) * duration / f64::from(steps), step(&scene, a, duration / f64::from(steps)));
        if now.normal < 0.0 && effects.contains("\"Unilateral\"") { break; } // the disc leaves the track: the output ends
        let (vx, vy) = (a.u * a.heading.cos(), a.u * a.heading.sin());
        writeln!(out, "{t},{},{},{},{vx},{vy},{},{},{}", a.x, a.y, a.theta, a.omega, now.normal, now.tangential)?;
        a = next;
    }
    out.flush()
}
