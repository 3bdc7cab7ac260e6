# Two commands for a newcomer: make demo, make test.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STATION := $(VENV)/.installed
TOOLS := $(VENV)/.installed-dev
WORKERS := -n 4 --dist loadfile --no-loadscope-reorder
INSTALL := STATION_VENV="$(VENV)" "$(PYTHON)" install.py

DIAGNOSES := $(addprefix tests/identify/test_, $(addsuffix .py, floor_not_reached above_the_floor curve_evidence diagnose judgement \
  second_mass))

.PHONY: help install launcher demo test check kernel bench pictures constraints docs clean

help:  ## what can be made
	@grep -hE '^[a-z]+:.*##' Makefile | sed 's/:.*##/ -/'

$(STATION): pyproject.toml constraints.txt
	@$(INSTALL)
	@touch $@

$(TOOLS): pyproject.toml constraints.txt
	@$(INSTALL) --dev
	@touch $(STATION) $@

install: $(STATION) launcher  ## create .venv, install the station, put `station` where a shell finds it

launcher: $(STATION)
	@$(INSTALL) --launcher

demo: $(STATION)  ## run the main job on the simulated board
	@$(BIN)/station demo
	@$(INSTALL) --launcher

check: $(TOOLS)  ## format, lint, types, import contracts
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

test: $(TOOLS)  ## the tests; with SLOW=1 those that take long, too
	$(BIN)/pytest $(WORKERS) $(if $(SLOW),-m "")

kernel: $(TOOLS)  ## diagnoses on other arithmetic: linear algebra without AVX, compiled code for any x86-64
	OPENBLAS_CORETYPE=Prescott NUMBA_CPU_NAME=generic NUMBA_CACHE_DIR="$(CURDIR)/build/kernel" \
	  $(BIN)/pytest $(WORKERS) $(DIAGNOSES)

bench: $(TOOLS)  ## the long proofs; results go to docs/benchmarks.md
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[bench]'
	$(BIN)/python -m bench

pictures: $(TOOLS)  ## the pictures of the documentation, of the page as it is
	$(BIN)/python -m bench.pictures

constraints:  ## the versions that are installed from now on: the newest, in a fresh environment; then run the tests
	rm -rf build/newest
	STATION_VENV=build/newest "$(PYTHON)" install.py --dev --newest
	build/newest/bin/python -m pip freeze --all --exclude-editable | grep -v "^pip==" | grep -E '^[A-Za-z0-9._-]+==[0-9][0-9A-Za-z.+!-]*$$' > constraints.txt

docs: $(STATION)  ## the documentation as a site, in site/; a broken link fails
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[docs]'
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build

clean:  ## remove what was made
	-@$(INSTALL) --remove
	rm -rf $(VENV) build site *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
