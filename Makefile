# Every target does its own set-up: a fresh machine needs Python (3.10 or newer) with venv, and make.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/$(if $(filter Windows_NT,$(OS)),Scripts,bin)
# Pytest would import the root as a package, which a clone called `mukca-main` has no name for.
TESTS_ALONE := --confcutdir=tests
# One test process more than cores: some tests wait for terminals.
PYTEST := $(BIN)/pytest $(TESTS_ALONE) -n $(shell expr $$(getconf _NPROCESSORS_ONLN) + 1) --dist worksteal
PACKAGE := pyproject.toml constraints.txt
# Names and versions of everything that is ever installed, build tools included.
# A URL has no blank, at which pip would see two files.
BLANK := $() $()
export PIP_CONSTRAINT := file://$(if $(filter Windows_NT,$(OS)),/)$(subst $(BLANK),%20,$(CURDIR))/constraints.txt
export PIP_BUILD_CONSTRAINT := $(PIP_CONSTRAINT)
# Compiled modules are kept: the tests start the program some hundred times.
unexport PYTHONDONTWRITEBYTECODE
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.PHONY: demo test test-fast pythons portable lint install docs wheel clean

demo: $(VENV)/.product  ## set up what the product needs, and run the main job on a simulated arm
	$(BIN)/mukca demo --out demo --force

test: $(VENV)/.tests  ## set up, and run all tests
	$(PYTEST) $(ARGS)

test-fast: $(VENV)/.tests  ## the tests to run while working: all but the slow ones
	$(PYTEST) -m "not slow" $(ARGS)

pythons: $(VENV)/.tests  ## the main job by each supported Python that is here, installed with nothing else
	rm -rf build/lib build/bdist.* build/wheel
	$(BIN)/pip wheel --quiet --no-deps --wheel-dir build/wheel .
	$(BIN)/python packaging/try_wheel.py build/wheel/*.whl

lint: $(VENV)/.tests  ## ruff and pyright (strict) for all three systems, on Python 3.11 and newer
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/pyright --pythonplatform Windows drivers recorder tools
	$(BIN)/pyright --pythonplatform Darwin drivers recorder tools

portable: $(VENV)/.portable  ## what needs no terminal and no robot, for Windows: types, and the solver's tests
	$(BIN)/pyright
	$(BIN)/pytest $(TESTS_ALONE) -m "not slow" tests/solver tests/tools/printables $(ARGS)

docs: $(VENV)/.docs  ## the documentation as static files in build/docs; every link is checked
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --site-dir build/docs

wheel: $(VENV)/.release  ## dist/: wheel and sdist, checked, and tried in an empty environment
	rm -rf dist build/lib build/bdist.*
	$(BIN)/python -m build
	$(BIN)/twine check --strict dist/*
	$(BIN)/python packaging/try_wheel.py dist/*.whl

install: $(VENV)/.tests  ## .venv with the project in it, editable, and all that its tests need

clean:
	rm -rf $(VENV) build demo dist *.egg-info

$(BIN)/pip:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.product: $(PACKAGE) | $(BIN)/pip
	$(BIN)/pip install --quiet --editable .
	@touch $@

$(VENV)/.portable: $(PACKAGE) | $(BIN)/pip
	$(BIN)/pip install --quiet --editable '.[isotp,lint,print,ros]' pytest pytest-timeout trimesh
	@touch $@

$(VENV)/.docs: $(PACKAGE) | $(BIN)/pip
	$(BIN)/pip install --quiet --editable '.[docs]'
	@touch $@

$(VENV)/.release: $(PACKAGE) | $(BIN)/pip
	$(BIN)/pip install --quiet --editable '.[release]'
	@touch $@

$(VENV)/.tests: $(PACKAGE) | $(BIN)/pip
	$(BIN)/pip install --quiet --editable '.[test,lint]'
	@touch $@ $(VENV)/.product
