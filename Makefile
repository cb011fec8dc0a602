# `make help` says what there is. The environment is made in .venv, from a lock of tried versions.
PYTHON ?= python3
PYTEST_OPTIONS ?= -n auto --maxprocesses 4
# Many small products: threads that wait for each other make them slower, tenfold on a busy machine.
ONE_THREAD := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
BIN := .venv/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet

.PHONY: help setup system check test test-all run bench wheel docs
.DEFAULT_GOAL := help

help:
	@echo "make run     the reference rig at full size, into results/pesaresi2017/"
	@echo "make test    ruff, mypy, import contracts and the tests (PYTEST_OPTIONS='-k rig' for some of them);"
	@echo "             12 minutes on two cores"
	@echo "make test-all  the same with the tests that are marked long: whole searches, curves traced again and again"
	@echo "make bench   the benchmarks"
	@echo "make wheel   dist/updamp-*.whl, which pip installs without this folder"
	@echo "make docs    the documentation as a site, docs/_build/html/index.html"
	@echo "make setup   the environment in .venv, from requirements.lock (the others do it too)"

setup: .venv/ready

system:
	@$(PYTHON) tools/check_system.py

.venv/ready: requirements.lock requirements-cholmod.lock pyproject.toml | system
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed: make PYTHON=...")'
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv
	@echo "Installing the locked packages into .venv (a minute or two) ..."
	@$(PIP) install --requirement requirements.lock
	@$(PIP) install --no-deps --no-build-isolation --editable .
	@$(PIP) install --no-deps --requirement requirements-cholmod.lock > .venv/cholmod.log 2>&1 \
		|| echo "CHOLMOD (optional solver) was not built: needs gcc, Python's headers, libsuitesparse-dev; see .venv/cholmod.log"
	@mkdir -p .venv/types && ln -sfn ../.. .venv/types/updamp  # for mypy, see pyproject.toml
	@touch $@

docs: setup
	@$(BIN)/python -c 'import sphinx' 2>/dev/null || $(PIP) install --requirement requirements.lock
	$(BIN)/sphinx-build --fail-on-warning --keep-going --quiet -b html docs docs/_build/html

wheel: setup
	$(PIP) wheel --no-deps --wheel-dir dist .

check: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache

test: check
	$(ONE_THREAD) $(BIN)/pytest -m "not long" $(PYTEST_OPTIONS)

test-all: check
	$(ONE_THREAD) $(BIN)/pytest $(PYTEST_OPTIONS)

run: setup
	$(BIN)/updamp run rigs/pesaresi2017.toml --mesh full --out results/pesaresi2017

bench: setup
	$(BIN)/python benchmarks/bench.py
