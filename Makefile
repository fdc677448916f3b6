# Two commands do all the set-up on a new machine: `make report` and `make test`. Both are fast the second time.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

# Versions that were tested together; CONSTRAINTS=/dev/null installs the newest versions.
CONSTRAINTS ?= constraints/current.txt
# Modules are compiled when they are first imported: to compile all of them was 60 of an installation's 100 s of CPU time.
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile -c $(CONSTRAINTS)

# Where this is set, each of the many processes of a report or a test compiles all its imports again: 9 s of CPU, not 3.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: report quick shell test test-builds test-all smoke walk check gallery docs browser matrix clean

# Engines in addition to exudyn and pymunk: `make report EXTRAS="box2d bullet"`. They remain installed.
EXTRAS ?=
WANTED := $(addprefix $(VENV)/extra-,$(EXTRAS))

report: $(VENV)/installed $(WANTED)
	$(BIN)/python -m reports.build

quick: $(VENV)/installed $(WANTED)
	$(BIN)/python -m reports.build --quick

# A shell in which the commands of the README are found; `exit` leaves it.
shell: $(VENV)/installed
	@PATH="$(CURDIR)/$(BIN):$$PATH" VIRTUAL_ENV="$(CURDIR)/$(VENV)" $${SHELL:-/bin/sh}

# Two processes on two cores: hardly a test waits, and each process imports and collects all tests, 9 s of CPU.
JOBS ?= 2
test: $(VENV)/installed
	$(BIN)/python -m pytest -n $(JOBS) --dist loadfile

BUILDS := $(addprefix tests/,benchmarks browser commands docs fuzz reports walk yardstick)

# Tests of commands, stored files, figures and whole reports: scored, killed, resumed, given engines that fail; the page in
# a browser. Three processes on two cores: many of them wait for a disk, a time limit or another process.
test-builds: $(VENV)/installed
	$(BIN)/python -m pytest -n 3 --dist loadfile $(BUILDS)

# Tests that measure times run alone, at the end.
test-all: $(VENV)/installed
	$(BIN)/python -m pytest -n 2 --dist loadfile --thorough -m "not timed" tests
	$(BIN)/python -m pytest --thorough -m timed tests

# Every installed Python, lowest and newest versions, with and without heyoka: takes hours, writes a table in docs/install.md.
# An interrupted run continues where it stopped; make matrix ONLY="3.13 lowest" runs the environments so named.
matrix:
	$(PYTHON) tests/matrix.py $(if $(ONLY),--only $(ONLY))

# Tests that take seconds and detect a broken tree: exact values. `make check` has the rooms and their imports.
SMOKE := tests/taylor/test_reference_exact.py

smoke: $(VENV)/installed
	$(BIN)/python -m pytest -q $(SMOKE)

# The README's commands, with the wheel in an empty environment and an empty folder. About 80 s of CPU time.
walk: $(VENV)/installed
	$(BIN)/python -m pytest -q -m "slow or not slow" tests/walk -k "readme or wheel"

# Style and types, for contributors: formatting, names, language, glossary, directions of imports. No answer is tested.
check: $(VENV)/checkers
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/python -m pytest -q tests/style

# Runs the gallery and stores its outputs in it, for readers without Jupyter. Run it when a figure changes.
gallery: $(VENV)/documented
	$(BIN)/python .ci/gallery.py

# The site: site/index.html, with the report that is here. It fails on a broken link, and runs the gallery, but with
# `make docs GALLERY=false`.
docs: $(VENV)/documented
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict
	[ ! -d report ] || cp -r report site/
	@echo site/index.html

$(VENV)/documented: $(VENV)/installed
	$(PIP) -e ".[docs]"
	touch $@

# The browser driver for the tests of the page; the browser itself is the system's: apt-get install chromium.
browser: $(VENV)/installed
	$(PIP) -e ".[browser]"

# heyoka (the Taylor method) has wheels for Linux only; the suite works without it.
$(VENV)/installed: pyproject.toml constraints/current.txt
	$(PYTHON) -c 'import sys; sys.exit("Python 3.11 or newer is needed; try: make PYTHON=python3.11") if sys.version_info < (3, 11) else None'
	$(PYTHON) -m venv $(VENV)
	$(PIP) -e ".[taylor,test]" || { \
		echo "heyoka cannot be installed here; installing without it: DOP853 is used instead"; \
		$(PIP) -e ".[test]"; } || { \
		echo "these versions cannot be installed here; install the newest: make CONSTRAINTS=/dev/null"; exit 1; }
	touch $@

$(VENV)/checkers: $(VENV)/installed
	$(PIP) -e ".[check]"
	touch $@

$(VENV)/extra-%: $(VENV)/installed
	$(PIP) -e ".[$*]"
	touch $@

clean:
	rm -rf $(VENV) build site .cache *.egg-info
