# Continuous integration of an engine: tests of friction, then the same version and a worse one against the last report.
python -m pip install -qq --disable-pip-version-check pytest
cc -O2 -Wall -o my_engine my_engine.c -lm
pytest -q --slip-to-roll-engine ./my_engine  # first result
slip-to-roll report --quick --engine ./my_engine --solver reference --out released
slip-to-roll report --quick --engine ./my_engine --solver reference --out same --fresh
slip-to-roll compare released same --solver my_engine --worse-than 10%
sed -i 's/soft = 2e-3/soft = 2e-1/' my_engine.c && cc -O2 -Wall -o my_engine my_engine.c -lm
slip-to-roll report --quick --engine ./my_engine --solver reference --out worse
slip-to-roll compare released worse --solver my_engine --worse-than 10%
