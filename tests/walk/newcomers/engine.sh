# An engine of 35 lines of C, with regularised friction: compiled, compared with all others, and its facets.
cc -O2 -Wall -o my_engine my_engine.c -lm
slip-to-roll report --quick --engine ./my_engine  # first result
slip-to-roll cases export "disc_on_line[mu=0.1]" --points 2001 --out scene
python -c 'import json; scene = json.load(open("scene/scene.json")); print(json.dumps(scene | {"setting": {"h": 1e-3}}))' > input.json
./my_engine < input.json > mine.csv
slip-to-roll compare "disc_on_line[mu=0.1]" mine.csv
