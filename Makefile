# Everything a person does here. `make help` lists it.

PYTHON ?=
ARGS ?=
BIN := .venv/bin
export PATH := $(CURDIR)/$(BIN):$(PATH)
ONE_THREAD := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1

.DEFAULT_GOAL := help
.PHONY: help setup all-sets peers develop plain demo test test-fresh test-newest test-oldest soak sanitize mutants codegen codegen-check study speed kernels compare error-control charts gallery docs package aarch64 lint format clean

help: ## Show this list
	@echo 'make TARGET            (ARGS="...": extra arguments)'
	@awk -F ':.*## ' '/^[a-z0-9-]+:.*## / {printf "  %-15s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

setup: ## Install what is missing: system packages, .venv, the package
	@PYTHON="$(PYTHON)" tools/setup.sh

all-sets: ## Compile for every instruction set that this machine runs, not for the widest alone
	@PYTHON="$(PYTHON)" tools/setup.sh all-sets

peers: ## Install the other codes of the studies: Exudyn, SUNDIALS, PyElastica
	@PYTHON="$(PYTHON)" tools/setup.sh peers

develop: ## Install so that importing the package compiles what has changed
	@PYTHON="$(PYTHON)" tools/setup.sh develop

plain: ## Undo `make develop`: install a copy, which no import changes
	@PYTHON="$(PYTHON)" tools/setup.sh plain

demo: setup ## Reproduce the paper's table 1 and figures 1 and 2
	$(ONE_THREAD) $(BIN)/python -m benchmarks table1 $(ARGS)

test: all-sets ## Run the tests, e.g. ARGS="-m 'not slow'"
	$(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder $(ARGS)

test-fresh: ## Run the set-up commands and examples of README.md in a bare Debian 12; as root, a quarter of an hour
	tools/test_fresh.sh $(ARGS)

test-newest: ## Run the fast tests with the newest interpreter here and the newest dependencies
	@PYTHON="$(PYTHON)" tools/test_versions.sh newest $(ARGS)

test-oldest: ## Run the fast tests with Python 3.11 and the oldest dependencies of pyproject.toml
	@PYTHON="$(PYTHON)" tools/test_versions.sh oldest $(ARGS)

soak: setup ## Run random trials: motions, contacts, calls, units, files, interruptions, e.g. ARGS="--seed 3 --seconds 120"
	$(ONE_THREAD) $(BIN)/python -m tests.soak $(ARGS)

SANITIZED := -m 'not slow' tests/threads tests/kernels tests/seeds tests/system tests/nonlinear tests/integrators
sanitize: setup ## Run tests of compiled code under address and undefined-behaviour sanitizers
	tools/sanitize.sh $(if $(ARGS),$(ARGS),$(SANITIZED))

mutants: develop ## Change hot code in small wrong ways, in place, and see whether tests fail; half an hour
	$(BIN)/python tools/mutants.py $(ARGS)

codegen: setup ## Derive the elements with SymPy and write generated/
	$(BIN)/python -m codegen $(ARGS)

codegen-check: setup ## Prove that generated/ is what `make codegen` writes
	$(BIN)/python -m codegen --check $(ARGS)

study: setup ## Run a study, e.g. ARGS="accuracy total-error"; ARGS="--help" lists them
	$(ONE_THREAD) $(BIN)/python -m benchmarks $(if $(ARGS),$(ARGS),--help)

speed: peers ## Time the paper's pendulum in turn with Exudyn, one thread
	$(ONE_THREAD) $(BIN)/python -m benchmarks speed pendulum $(ARGS)

kernels: all-sets ## Time every element kernel on every instruction set
	$(ONE_THREAD) $(BIN)/python -m benchmarks speed kernels $(ARGS)

compare: setup ## Compare speed and counts with another build, ARGS="OTHER/.venv/bin/python"
	$(ONE_THREAD) $(BIN)/python -P tools/compare_builds.py $(ARGS)

error-control: setup ## Measure errors and costs of simulate(accuracy=) on 100 scenes, e.g. ARGS="0 20"; ten minutes
	$(ONE_THREAD) $(BIN)/python -m benchmarks.random_scenes.sweep $(ARGS)

# The studies that count come first, those that take longest last; each prints its command.
STUDIES := \
  'stability map --page docs/stability.md' \
  'stability contact --page docs/stability.md' \
  'stability factorizations --page docs/stability.md' \
  'table1 --page README.md --page docs/benchmarks.md' \
  'contact wrapped-cylinder --page docs/contact.md' \
  'contact references --part all --page docs/contact.md' \
  'speed pendulum --page docs/benchmarks.md' \
  'scaling secant-pairs --page docs/large.md' \
  'scaling lattice-pairs --page docs/large.md' \
  'scaling lattices --largest 46 --largest-net 200 --page docs/large.md' \
  'stability long-runs --page docs/stability.md' \
  'accuracy error-budget --page docs/accuracy.md' \
  'accuracy total-error --peers --page docs/accuracy.md' \
  'accuracy work-precision --peers --page docs/accuracy.md' \
  'scaling sizes --peers --largest 1000000 --largest-net 200 --page docs/large.md'

charts: peers ## Run the studies of the pages again, with their charts and tables; an hour
	@for study in $(STUDIES); do \
	  echo "== python -m benchmarks $$study"; \
	  $(ONE_THREAD) $(BIN)/python -m benchmarks $$study || exit; \
	done
	mkdir -p docs/data && cp results/stability.csv results/stability-contact.csv docs/data/

gallery: setup ## Draw the pictures of docs/gallery.md by its examples, e.g. ARGS="net"
	$(BIN)/python tools/gallery.py $(ARGS)

docs: setup ## Build the documentation site in build/site, e.g. ARGS="-E" from the beginning; a minute
	tools/build_docs.sh $(ARGS)

package: setup ## Build sdist and wheel, and run README.md's examples where only the wheel is installed; ten minutes
	tools/package.sh $(ARGS)

aarch64: setup ## Build the wheel for 64-bit ARM here, compare and test it under emulation; half an hour
	tools/aarch64.sh $(ARGS)

lint: setup ## Check style, types, the order of the rooms, and what fails elsewhere
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/python tools/lint_imports.py
	$(BIN)/python tools/lint_portable.py

format: setup ## Put the source into the shape `make lint` asks for
	$(BIN)/ruff check --fix
	$(BIN)/ruff format

clean: ## Remove .venv and everything built
	rm -rf .venv build results ancfsparse/compiled .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
