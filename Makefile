# Two commands do it all on a fresh machine: `make demo` and `make test`.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
# the rope of the demo: python, the form to read, or native, the same in C
FLAVOUR ?= python
FMU_python := build/balance_rope.fmu
FMU_native := build/balance_rope_native.fmu
EXPORT_native := --native
SAID_python := the rope runs in Python, the form to read; make demo FLAVOUR=native winds it in C, and README.md, How fast, compares
SAID_native := the rope runs in C
READY := $(VENV)/.ready
# one process per core, each with one thread; one that has no tests left takes over half of those of another
PYTEST := OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n logical --dist worksteal

.PHONY: demo test test-slow lint docs evidence bench winding robustness poses stability reproduce chart mesh-rule contact guards shafts tangle promise integrators peer validate knowledge reference choice hoist coupling latency studies throughput terms fuzz fmu wheels wheel-test release clean

demo: $(READY)
	$(if $(FMU_$(FLAVOUR)),,$(error FLAVOUR=$(FLAVOUR) must be python or native))
	$(BIN)/balance-rope export $(EXPORT_$(FLAVOUR)) --outputs all --platform host
	@echo "$(SAID_$(FLAVOUR))"
	$(BIN)/balance-rope demo --fmu $(FMU_$(FLAVOUR))

test: $(READY)
	$(PYTEST)

test-slow: $(READY)
	$(PYTEST) -m slow

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	git ls-files '*.c' '*.h' '*.inc' ':!fmu_src/native/include' | xargs $(BIN)/clang-format --dry-run -Werror
	$(BIN)/mypy
	git ls-files '*.md' '*.j2' '*.py' '*.c' '*.h' ':!tests' | xargs $(BIN)/codespell
	git ls-files '*.md' ':!docs/data' | xargs $(BIN)/proselint check

docs: $(READY)
	$(BIN)/python -m pip install --quiet -e '.[docs]'
	$(BIN)/python -m sphinx -E -W --keep-going -q -b html docs build/site

evidence: $(READY)
	$(BIN)/python -m evidence

bench: $(READY)
	$(BIN)/python -m benchmarks.speed

winding: $(READY)
	$(BIN)/python -m benchmarks.winding

robustness: $(READY)
	$(BIN)/python -m benchmarks.robustness

shafts: $(READY)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.shafts

poses: $(READY)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.poses

stability: $(READY)
	$(BIN)/python -m evidence.stability

reproduce: $(READY)
	$(BIN)/python -m evidence.reproduction

chart: $(READY)
	$(BIN)/python -m evidence.chart

mesh-rule: $(READY)
	OMP_NUM_THREADS=1 $(BIN)/python -m evidence.mesh_rule

contact: $(READY)
	OMP_NUM_THREADS=1 $(BIN)/python -m evidence.contact

guards: $(READY)
	OMP_NUM_THREADS=1 $(BIN)/python -m evidence.guards

tangle: $(READY)
	OMP_NUM_THREADS=1 $(BIN)/python -m evidence.tangle

promise: $(READY)
	OMP_NUM_THREADS=1 $(BIN)/python -m evidence.promise

integrators: $(READY)
	OMP_NUM_THREADS=1 $(BIN)/python -m evidence.integrators

peer: $(READY)
	$(BIN)/python -m pip install --quiet -e '.[peer]'
	$(BIN)/python -m evidence.peer

validate: $(READY)
	$(BIN)/python -m pip install --quiet -e '.[validation]'
	OMP_NUM_THREADS=1 $(BIN)/python -m evidence.validation

knowledge: $(READY)
	OMP_NUM_THREADS=1 $(BIN)/python -m evidence.knowledge

reference: $(READY)
	$(BIN)/python -m evidence.discrete_rod

choice: $(READY)
	$(BIN)/python -m evidence.choice

hoist: $(READY)
	$(BIN)/python -m evidence.hoist

coupling: $(READY)
	OMP_NUM_THREADS=1 $(BIN)/python -m evidence.coupling

latency: $(READY)
	OMP_NUM_THREADS=1 $(BIN)/python -m evidence.latency

fuzz: $(READY)
	$(BIN)/python -m benchmarks.fuzz --minutes 30 --csv docs/data/fuzz.csv

STUDY_FMUS = $(BIN)/balance-rope export --native --platform host --level draft --out build/draft.fmu && \
	$(BIN)/balance-rope export --native --platform host --out build/standard.fmu

studies: $(READY)
	$(STUDY_FMUS)
	$(BIN)/balance-rope study docs/studies/controllers.toml
	$(BIN)/balance-rope study docs/studies/controllers_complete.toml
	$(BIN)/balance-rope study docs/studies/swivel.toml
	$(BIN)/balance-rope study docs/studies/creep.toml
	$(BIN)/balance-rope study docs/studies/tuning.toml
	$(BIN)/python -m evidence.studies

terms: $(READY)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.terms

throughput: $(READY)
	$(STUDY_FMUS)
	$(BIN)/python -m benchmarks.throughput

fmu: $(READY)
	$(BIN)/balance-rope export --outputs all --platform host

wheels: $(READY)
	$(BIN)/python -m release.wheels build/wheels

wheel-test: wheels
	$(BIN)/python -m release.trial build/wheels/*.whl

release: $(READY)
	$(BIN)/python -m release dist

$(READY): pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit("Python 3.11 or newer is needed; run make PYTHON=python3.12 demo" if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet -e '.[dev]'
	touch $@

clean:
	rm -rf $(VENV) build dist out *.egg-info
