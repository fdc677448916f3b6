# Continuous integration of an engine: tests of friction, then a new version against the last one.
python -m pip install -qq --disable-pip-version-check pytest
cc -O2 -Wall -o my_engine my_engine.c -lm
pytest -q --slip-to-roll-engine ./my_engine  # first result
slip-to-roll report --quick --engine ./my_engine --solver reference --out released
sed -i 's/soft = 2e-3/soft = 2e-1/' my_engine.c && cc -O2 -Wall -o my_engine my_engine.c -lm
slip-to-roll report --quick --engine ./my_engine --solver reference --out candidate
slip-to-roll gate --baseline released candidate --solver my_engine
