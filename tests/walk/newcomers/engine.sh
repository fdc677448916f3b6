# An engine of 35 lines of C, with regularised friction: compared with all others, and tested by the laws of mechanics.
cc -O2 -Wall -o my_engine my_engine.c -lm
slip-to-roll report --quick --engine ./my_engine  # first result
slip-to-roll laws ./my_engine
sed -i 's/"Flight"}/"Flight", "Load", "Belt", "Drive", "BySpeed", "\\"inertia\\": null"}/' my_engine.c && cc -O2 -Wall -o my_engine my_engine.c -lm
slip-to-roll laws ./my_engine
sed 's/-mu/-0.9 * mu/' my_engine.c > weak.c && cc -O2 -Wall -o weak weak.c -lm
slip-to-roll laws ./weak --law friction_torque
slip-to-roll cases export "disc_on_line[mu=0.1]" --points 2001 --out scene
python -c 'import json; scene = json.load(open("scene/scene.json")); print(json.dumps(scene | {"setting": {"h": 1e-3}}))' > input.json
./my_engine < input.json > mine.csv
slip-to-roll compare "disc_on_line[mu=0.1]" mine.csv
