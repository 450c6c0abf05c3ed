# Everything a checkout needs, with nothing but Python 3.11 and make. `make help` lists the targets.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed
WARM := $(VENV)/.warm
DEMO := out/demo
DEMO_SEED := 1

# What is compiled or cached by `mamo warmup`: a change here warms up again.
KERNELS := $(shell find mamo_core plugins -name '*.py')

# What `mamo plugins new` writes is checked like everything else.
TEMPLATES := $(patsubst %/tests,%,$(wildcard mamo_core/scaffold/templates/*/tests))
EMPTY :=
SPACE := $(EMPTY) $(EMPTY)

# One thread for each process: tests run in parallel, benchmarks compare single cores.
export OMP_NUM_THREADS := 1
export OPENBLAS_NUM_THREADS := 1
export MKL_NUM_THREADS := 1
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.PHONY: help setup demo pictures test test-view check bench docs reference pictures-docs clean
.DEFAULT_GOAL := help

help:
	@echo "make demo       set up, generate a scene, plan, verify, draw ($(DEMO)/plan.png)"
	@echo "make test       linters, types, import rules, all tests but those of test-view"
	@echo "make test-view  replays in Chromium and pictures in 3-D (Debian packages: see README.md)"
	@echo "make check      linters, types and import rules"
	@echo "make bench      speed of the parts beside their targets"
	@echo "make docs       the documentation as a site (out/docs/index.html)"
	@echo "make reference  its pages that are written from the code (docs/reference)"
	@echo "make pictures   docs/images, anew (on Debian: packages libegl1 and libgl1-mesa-dri)"
	@echo "make pictures-docs  the pictures of docs/how_a_plan_comes_about.md"
	@echo "make setup      only the virtual environment $(VENV), with compiled kernels"
	@echo "make clean      remove everything that was made"

setup: $(WARM)

$(INSTALLED): pyproject.toml constraints.txt
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@echo "installing mamo and its dependencies into $(VENV)"
	@$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[dev]'
	@touch $@

$(WARM): $(INSTALLED) $(KERNELS)
	@echo "building robots and compiling kernels"
	@$(BIN)/mamo warmup
	@touch $@

demo: $(WARM)
	@mkdir -p $(DEMO)
	$(BIN)/mamo problem generate shelf --level medium --movables 10 --seed $(DEMO_SEED) \
		-o $(DEMO)/problem.json
	$(BIN)/mamo plan $(DEMO)/problem.json -o $(DEMO)/plan.json --png $(DEMO)/plan.png
	$(BIN)/mamo verify $(DEMO)/plan.json

pictures: demo
	cp $(DEMO)/plan.png docs/images/demo.png
	$(BIN)/mamo view $(DEMO)/plan.json --still docs/images/demo_3d.png --gif docs/images/replay.gif
	$(BIN)/mamo plan $(DEMO)/problem.json --planner em4m --set 'search.nearby={}' \
		--graph docs/images/search.svg
	$(BIN)/mamo plan problems/impossible/into_glass.yaml --set search.regions=2 \
		--png docs/images/no_plan.png; test $$? -eq 3

check: $(INSTALLED)
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	MYPYPATH=benchmarks $(BIN)/mypy benchmarks/*.py
	MYPYPATH=tools $(BIN)/mypy tools/*.py
	MYPYPATH=$(subst $(SPACE),:,$(TEMPLATES)) $(BIN)/mypy $(TEMPLATES:%=%/*/*.py)
	$(BIN)/lint-imports

test: check $(WARM)
	$(BIN)/python -m pytest -n auto

test-view: $(WARM)
	$(BIN)/python -m pytest -m 'browser or rendering' tests/browser tests/rendering

bench: $(WARM)
	$(BIN)/python benchmarks/micro.py

docs: $(INSTALLED)
	$(BIN)/python -m sphinx -q -E -W --keep-going -d out/docs.cache docs out/docs
	@echo "out/docs/index.html"

reference: $(INSTALLED)
	$(BIN)/python tools/reference.py

pictures-docs: $(WARM)
	$(BIN)/python tools/walkthrough.py

clean:
	rm -rf $(VENV) out build dist .pytest_cache .mypy_cache .ruff_cache .import_linter_cache \
		.hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
