# Two commands do everything on a fresh machine: `make report` and `make test`. Both are quick the second time.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

# What one run of the tests derives and compiles serves the next one; `make clean` forgets it.
KEPT := SLIP_TO_ROLL_CACHE=$(CURDIR)/$(VENV)/kept

.PHONY: report quick test test-all smoke check docs browser clean

# Engines beside exudyn and pymunk: `make report EXTRAS="box2d bullet"`. They stay installed.
EXTRAS ?=
WANTED := $(addprefix $(VENV)/extra-,$(EXTRAS))

report: $(VENV)/installed $(WANTED)
	$(BIN)/python -m reports.build

quick: $(VENV)/installed $(WANTED)
	$(BIN)/python -m reports.build --quick

test: $(VENV)/installed check
	$(KEPT) $(BIN)/python -m pytest -n 2 --dist loadfile

# What is timed is timed alone, at the end.
test-all: $(VENV)/installed check
	$(KEPT) $(BIN)/python -m pytest -n 2 --dist loadfile -m "slow or not slow" --ignore=tests/reports/test_clock.py
	$(KEPT) $(BIN)/python -m pytest -m "slow or not slow" tests/reports/test_clock.py

# What is over in seconds and says that nothing is broken outright: rooms, their arrows, exact values.
SMOKE := tests/test_architecture.py tests/test_import_layers.py tests/reference/test_reference_exact.py

smoke: $(VENV)/installed check
	$(KEPT) $(BIN)/python -m pytest -q $(SMOKE)

check: $(VENV)/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

# The site: site/index.html. It runs the gallery.
docs: $(VENV)/documented
	$(KEPT) NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --quiet
	@echo site/index.html

$(VENV)/documented: $(VENV)/installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[docs]"
	touch $@

# What drives a browser in the tests of the page; the browser itself is the system's: apt-get install chromium.
browser: $(VENV)/installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[browser]"

# heyoka (the Taylor method) has wheels for some machines only; without it everything still works.
$(VENV)/installed: pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit("Python 3.11 or newer is needed; try: make PYTHON=python3.11") if sys.version_info < (3, 11) else None'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[taylor,test]" \
		|| $(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[test]"
	touch $@

$(VENV)/extra-%: $(VENV)/installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[$*]"
	touch $@

clean:
	rm -rf $(VENV) build site .cache *.egg-info
