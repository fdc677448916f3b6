# A maintainer: a case of her own, run and tested; then an adapter from the starter in a package of her own.
python -m pip install -qq --disable-pip-version-check pytest
slip-to-roll cases new bump
sed -i 's/-depth \* cos(2 \* s)/depth * exp(-(s**2)) - 0.6 * s/; s/import cos/import exp/' bump.py
slip-to-roll cases check bump.py  # first result
slip-to-roll report --quick --case-file bump.py
pytest -q --case-file=bump.py
pytest -q --case-file=bump.py --slip-to-roll-engine pymunk
mkdir my_package && cp adapter.py my_package/
printf '[project]\nname = "my-package"\nversion = "1.0"\nentry-points."slip_to_roll.adapters".my_engine = "my_package.adapter"\n[tool.setuptools]\npackages = ["my_package"]\n' > pyproject.toml
python -m pip install -qq --disable-pip-version-check .
slip-to-roll report --quick --solver reference my_engine --out mine
pytest -q --slip-to-roll-engine my_engine
slip-to-roll laws my_engine
python -m pip uninstall -qq --yes my-package
