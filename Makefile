# `make demo` shows the headline case, `make test` runs the tests, `make help` lists the rest.
# Needs make and Python 3.11 or newer; everything else goes into .venv.

SHELL := /bin/sh
VENV := .venv
BIN := $(VENV)/bin
OUT := out
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet
DEMOS := $(patsubst demos/%.py,%,$(sort $(wildcard demos/*.py)))
PYTEST_ARGS ?=
# each core takes a test file at a time
SHARES := -n logical --dist loadfile

.DEFAULT_GOAL := help
.PHONY: help install dev demo demos cases test lint types check faults bench lock clean distclean $(DEMOS:%=demo-%)

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z]+:.*## /{printf "  make %-9s %s\n", $$1, $$2}' Makefile

# Python: the first that is new enough; `make PYTHON=/path/to/python ...` takes another.
FIND_PYTHON = for p in $(PYTHON) python3.11 python3.12 python3.13 python3.14 python3 python; do \
	  "$$p" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 && break; p=; \
	done; \
	test -n "$$p" || { echo "No Python 3.11 or newer found.  try: make PYTHON=/path/to/python"; exit 1; }

$(VENV)/.made:
	@$(FIND_PYTHON); \
	echo "Creating $(VENV) with $$($$p --version)"; \
	"$$p" -m venv $(VENV) || { echo "try: install the venv module of $$p"; exit 1; }
	@touch $@

# The pinned versions where this Python has them, else what pyproject.toml allows.
$(VENV)/.installed: $(VENV)/.made pyproject.toml
	@echo "Installing pmesh into $(VENV), a minute or so the first time"
	@$(PIP) install --constraint requirements-dev.lock --editable . \
	  || { echo "The pinned versions do not fit here: taking the newest"; $(PIP) install --editable .; }
	@touch $@

$(VENV)/.developed: $(VENV)/.made requirements-dev.lock pyproject.toml
	@echo "Installing the development tools and pmesh into $(VENV)"
	@$(PIP) install --requirement requirements-dev.lock
	@$(PIP) install --no-deps --editable .
	@touch $@ $(VENV)/.installed

install: $(VENV)/.installed ## create .venv and install pmesh into it

dev: $(VENV)/.developed ## the same with the pinned development tools

demo: $(VENV)/.installed ## flow past a cylinder at Re = 550: drag, picture, data (under a minute)
	@echo "Flow past an impulsively started cylinder at Re = 550, until T = U t / R = 6"
	@$(BIN)/pmesh run cylinder --out $(OUT)/cylinder --overwrite
	@echo
	@echo "Picture:  $(OUT)/cylinder/figure.png"
	@echo "ParaView: $(OUT)/cylinder/fields.vtkhdf"

demos: $(DEMOS:%=demo-%) ## every script in demos/; make demos QUICK=--quick shortens them

$(DEMOS:%=demo-%): demo-%: $(VENV)/.installed
	@echo "demos/$*.py"
	@$(BIN)/python demos/$*.py $(QUICK) --out $(OUT)/demos/$*

cases: $(VENV)/.installed ## every named case; make cases QUICK=--quick shortens them
	@for case in $$($(BIN)/pmesh cases | cut -d' ' -f1); do \
	  $(BIN)/pmesh run $$case $(QUICK) --out $(OUT)/cases/$$case --overwrite || exit 1; \
	done

test: $(VENV)/.developed ## the tests
	@$(BIN)/python -m pytest $(SHARES) $(PYTEST_ARGS)

lint: $(VENV)/.developed ## style, format and the direction of imports
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/lint-imports

types: $(VENV)/.developed ## mypy --strict
	@$(BIN)/mypy

check: lint types test ## lint, types and tests

faults: $(VENV)/.developed ## deliberate faults: each must make a test fail (some minutes)
	@$(BIN)/python benchmarks/faults.py

bench: $(VENV)/.developed ## what a step, a solve, remeshing and a start cost (some minutes)
	@$(BIN)/python benchmarks/step.py
	@$(BIN)/python benchmarks/poisson.py
	@$(BIN)/python benchmarks/remeshing.py
	@$(BIN)/python benchmarks/startup.py

lock: $(VENV)/.made ## refresh requirements-dev.lock with the newest versions
	@rm -rf build/lock
	@$(BIN)/python -m venv build/lock
	@build/lock/bin/python -m pip --disable-pip-version-check --quiet install --editable ".[dev,ducc]"
	@build/lock/bin/python -m pip freeze --exclude-editable \
	  | tr 'A-Z_' 'a-z-' | LC_ALL=C sort > requirements-dev.lock
	@rm -rf build/lock
	@echo "requirements-dev.lock: $$(wc -l < requirements-dev.lock) packages; run make check with it"

clean: ## remove caches, compiled kernels and build leftovers; .venv and out/ stay
	@rm -rf build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	@find remesh levelset pmesh tests demos benchmarks -name __pycache__ -prune -exec rm -rf {} +

distclean: clean ## the same, and .venv
	@rm -rf $(VENV) *.egg-info
