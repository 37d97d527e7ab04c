# `make help` lists the targets; `make demo` and `make test` do it all on a fresh machine.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
# both flavours of the rope
FMU_PYTHON := build/balance_rope.fmu
FMU_NATIVE := build/balance_rope_native.fmu
# the environment, and what is installed there: for the product, for tests and evidence, for developers
MADE := $(VENV)/.made
PRODUCT := $(VENV)/.product
READY := $(VENV)/.ready
DEV := $(VENV)/.dev
# one process per core, each with one thread; idle ones take over tests; imported modules are compiled to bytecode once
TESTS := -m pytest -n logical --dist worksteal
PYTEST := OMP_NUM_THREADS=1 PYTHONDONTWRITEBYTECODE= $(BIN)/python $(TESTS)
# an environment with the lowest versions that pyproject.toml allows and this Python has
LOWEST ?= build/lowest
MEASURE := OMP_NUM_THREADS=1 $(BIN)/python -m evidence --measure

.PHONY: help demo test test-slow test-lowest hunt lint docs evidence reproduce accuracy promise stability validate contact signals motion bench csources wheels release clean

help:  ## list the targets
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/\1: \2/p' $(MAKEFILE_LIST) | awk -F ': ' '{ printf "%-12s %s\n", $$1, $$2 }'

demo: $(PRODUCT)  ## export both flavours, wind a hoist with the native FMU, compare the Python FMU with it
	$(BIN)/balance-rope export --python --native --outputs all --platform host
	$(BIN)/balance-rope wind --fmu $(FMU_NATIVE) --out out/demo
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.flavours $(FMU_PYTHON) $(FMU_NATIVE)

test: $(READY)  ## run the tests, on all cores
	$(PYTEST)

test-slow: $(READY)  ## run the tests that are marked slow
	$(PYTEST) -m slow

# seed of the scenes, minutes for which they are drawn, or one case, one relation of it, and features that it goes without
MINUTES ?= 60
HUNT = --seed $(SEED) --minutes $(MINUTES) $(if $(CASE),--case $(CASE)) $(if $(RELATION),--relation $(RELATION))
hunt: $(READY)  ## try relations that must hold on random scenes, as make hunt SEED=7 MINUTES=60
	$(if $(SEED),,$(error SEED must be a number: make hunt SEED=7))
	OMP_NUM_THREADS=1 PYTHONPATH=.:tests/helpers $(BIN)/python -m invariants $(HUNT) $(if $(WITHOUT),--without "$(WITHOUT)") $(if $(LOG),--log)

test-lowest:  ## run the tests with the lowest versions of the packages that pyproject.toml allows
	$(PYTHON) -m venv --clear $(LOWEST)
	$(LOWEST)/bin/python -m pip install --quiet uv
	$(LOWEST)/bin/uv pip compile --quiet --resolution lowest-direct --only-binary :all: --extra test \
		--python $(LOWEST)/bin/python --output-file $(LOWEST)/requirements.txt pyproject.toml
	$(LOWEST)/bin/python -m pip install --quiet --no-compile -r $(LOWEST)/requirements.txt
	$(LOWEST)/bin/python -m pip install --quiet --no-deps -e .
	OMP_NUM_THREADS=1 PYTHONDONTWRITEBYTECODE= $(LOWEST)/bin/python $(TESTS)

lint: $(DEV)  ## run ruff, clang-format, mypy, codespell and proselint
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	git ls-files '*.c' '*.h' '*.inc' | xargs $(BIN)/clang-format --dry-run -Werror
	$(BIN)/mypy
	$(BIN)/mypy --strict examples/*.py
	git ls-files '*.md' '*.j2' '*.py' '*.c' '*.h' '*.inc' ':!tests' | xargs $(BIN)/codespell
	git ls-files '*.md' ':!docs/data' | xargs $(BIN)/proselint check

docs: $(READY)  ## build the site in build/site
	$(BIN)/python -m pip install --quiet -e '.[docs]'
	$(BIN)/python -m sphinx -E -W --keep-going -q -b html docs build/site

evidence: $(READY)  ## write the pages of evidence from the recorded data, without a run
	$(BIN)/python -m evidence

reproduce: $(READY)  ## run the published evaluation anew (3 minutes)
	$(BIN)/python -m evidence reproduction --measure reproduction

accuracy: $(READY)  ## measure accuracy and speed anew (30 minutes, on a quiet machine)
	$(MEASURE) accuracy choice latency -- accuracy levels

promise: $(READY)  ## compare requested and achieved accuracy on seeded scenes (half an hour)
	OMP_NUM_THREADS=1 $(BIN)/python -m evidence.promise

stability: $(READY)  ## run the scenes in which methods fail (3 minutes)
	$(MEASURE) stability coupling -- stability

validate: $(READY)  ## compare the model with measurements, theory and other codes (20 minutes)
	$(BIN)/python -m pip install --quiet -e '.[peer,validation]'
	$(MEASURE) validation discrete_rod exudyn -- validation accuracy
	OMP_NUM_THREADS=1 $(BIN)/python -m evidence.linear

contact: $(READY)  ## check contact against exact cases (3 minutes)
	$(MEASURE) contact:checks -- contact

signals: $(READY)  ## wind with motions that tables, rounding and repetition give (5 minutes)
	$(MEASURE) signals -- signals

# what is sought of the cables
CABLE ?= examples/measurements/motion.toml
motion: $(READY)  ## fit and judge cables that somebody has measured, in the folders of DATA (docs/howto/rope_data.md)
	$(if $(DATA),,$(error DATA must be the folder that you have fetched: make motion DATA=folder))
	OMP_NUM_THREADS=1 $(BIN)/python -m evidence.motion $(DATA) $(CABLE)

bench: $(READY)  ## measure the speed of every form of the rope, and windings per minute
	$(BIN)/python -m benchmarks.speed
	$(BIN)/balance-rope export --native --platform host --level draft --out build/draft.fmu
	$(BIN)/balance-rope export --native --platform host --out build/standard.fmu
	$(BIN)/python -m benchmarks.throughput --python

csources: $(READY)  ## put all C, written and generated, with compile_commands.json in build/csrc
	$(BIN)/python -m release.editor build/csrc

wheels: $(READY)  ## build the wheel in build/wheels, install it in a fresh environment without a compiler, and try it
	$(BIN)/python -m release.wheels build/wheels
	$(BIN)/python -m release.trial build/wheels/*.whl

release: $(READY)  ## build everything that is released, in dist
	$(BIN)/python -m release dist

$(MADE):
	$(PYTHON) -c 'import sys; sys.exit("Python 3.11 or newer is needed; run make PYTHON=python3.12 demo" if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	touch $@

$(PRODUCT): $(MADE) pyproject.toml
	$(BIN)/python -m pip install --quiet --no-compile -e '.[compiler]'
	touch $@

$(READY): $(MADE) pyproject.toml
	$(BIN)/python -m pip install --quiet --no-compile -e '.[test]'
	touch $@

$(DEV): $(READY)
	$(BIN)/python -m pip install --quiet -e '.[dev]'
	touch $@

clean:  ## remove the environment and what is built, not the results in out
	rm -rf $(VENV) build dist *.egg-info
