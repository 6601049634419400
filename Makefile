# Every command of the project. `make demo` and `make test` need nothing but Python 3.11+ and make.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
RUN    ?= runs/demo
KILLS  ?= runs/kills
# Processes that share the tests; more than two needs as many cores.
WORKERS ?= 2
# The tokenizer runs in Node; where PATH has none of version 18 or later, a wheel brings it.
NODE_EXTRA := $(shell node -e 'process.exit(parseInt(process.versions.node) < 18 ? 1 : 0)' 2>/dev/null || echo ,node)

.PHONY: demo test check hil hil-colony hil-parting firmware benchmark paper mutants fuzz-inputs kills hil-mutants clean setup clients

$(VENV)/.installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[dev$(NODE_EXTRA)]'
	touch $@

setup: $(VENV)/.installed  ## environment, packages, tokenizer
	$(BIN)/cgagen setup

demo: setup                ## evolve a predator, build the programs of all four Stamps, verify them
	rm -rf $(RUN)
	$(BIN)/cgagen evolve --seed 7 --run $(RUN)
	$(BIN)/cgagen info $(RUN)/best.genome
	$(BIN)/cgagen build $(RUN)/best.genome -o $(RUN)/build-predator
	$(BIN)/cgagen build --robot servobot-prey -o $(RUN)/build-prey
	$(BIN)/cgagen verify $(RUN)/best.genome --build $(RUN)/build-predator --report $(RUN)/verify-predator.html
	$(BIN)/cgagen verify --build $(RUN)/build-prey --report $(RUN)/verify-prey.html
	@echo; echo "The PBASIC programs are in $(RUN)/build-predator and $(RUN)/build-prey; what was"
	@echo "verified stands in $(RUN)/verify-predator.html and $(RUN)/verify-prey.html."

clients: setup             ## Parallax's JavaScript programmer, which the tests let loose on us
	$(BIN)/python -m tests.npm.fetch

test: setup clients check  ## set-up, then everything CI checks

check:                     ## lint, types, import contract, all tests
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python -m pytest -q -m "not slow" -n $(WORKERS) --dist loadfile

hil: setup                 ## the firmware against its specification, with a page about it
	mkdir -p runs
	$(BIN)/python -m pytest hil/ -q --hil-report runs/hil-report.html $(patsubst %,--hil-kills %,$(wildcard $(KILLS)/kills-*.json))

hil-colony: setup          ## whole robots from all 100 fixed starts: some minutes
	$(BIN)/python -m pytest hil/test_colony.py -q -m slow

hil-parting: setup         ## how far robots without referee, and on three lines, part from the simulator
	$(BIN)/python -m hil.rates --starts 100

firmware: setup            ## rebuild the checked-in reference firmware, and record its traces
	$(BIN)/cgagen build firmware/reference.genome -o firmware/predator --force
	$(BIN)/cgagen build --robot servobot-prey -o firmware/prey --force
	$(BIN)/python -m hil.traces.shipped

benchmark: setup           ## measure speed, as ratios in one run
	$(BIN)/cgagen benchmark

paper: setup               ## five full trials and the slow tests against the paper's claims
	$(BIN)/python -m pytest -q -m slow tests

mutants: setup             ## do the emulator's tests notice small changes of it?
	$(BIN)/python -m tests.mutate_emulator

fuzz-inputs: setup         ## damaged files of every kind for every reader: does each say what is wrong?
	$(BIN)/python -m tests.fuzz_inputs --count 20000 --seed 1

kills: setup               ## is anything half done left of verbs that are killed at any moment?
	$(BIN)/python -m tests.kill_verbs --count 300

hil-mutants: setup         ## do the firmware's checks notice small changes of it? which lines are met?
	mkdir -p $(KILLS)
	$(BIN)/python -m hil.kill --robot predator --out $(KILLS)/kills-predator.json
	$(BIN)/python -m hil.kill --robot prey --out $(KILLS)/kills-prey.json
	$(BIN)/python -m hil.kill 60 --robot predator-free
	$(BIN)/python -m hil.kill 60 --robot prey-free
	$(BIN)/python -m hil.covered

clean:                     ## forget the environment, caches and runs
	rm -rf $(VENV) runs dist .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
