# The two commands: make demo, make test. Everything goes into .venv; see .ci/environment.
SHELL := /bin/sh
BIN := .venv/bin
STAMPED := $(shell date +%Y%m%d-%H%M%S)
# A sourced ROS, or a middleware that is not in .venv, would end every node at once.
unexport RMW_IMPLEMENTATION PYTHONPATH PYTHONHOME AMENT_PREFIX_PATH

.PHONY: help environment demo test test_slow lint types compiled architecture unit kernels nodes validate bench sim_to_real predictivity soak signals exam mutants hostile hot_boxes pictures docs colcon clean
.DEFAULT_GOAL := help

help: ## Show this list
	@awk -F ':.*## ' '/^[a-z_]+:.*## / { printf "  make %-13s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

environment: ## Make .venv, some 2 GB from PyPI, or find it made (PYTHON=python3.12 chooses the interpreter)
	@PYTHON='$(PYTHON)' .ci/environment

demo: environment ## Run the bench with an outer-ring defect for 10 s: verdict, recording, view
	$(BIN)/dcrb bench outer_ring_defect --duration 10 --record recordings/demo-$(STAMPED)

# Two at a time: a node test waits for its nodes half of the time.
test: environment ## Run the checks that a change needs, some eight minutes on two cores
	@EXECUTE_NOTEBOOKS=false $(MAKE) --no-print-directory -j 2 types compiled lint architecture kernels docs
	@$(MAKE) --no-print-directory unit
	@$(MAKE) --no-print-directory nodes
	@echo "All checks hold; make test_slow runs the others."

test_slow: environment ## Run the other checks, which continuous integration runs as well
	@$(MAKE) --no-print-directory unit SPEED=slow
	@$(MAKE) --no-print-directory nodes SPEED=slow
	@$(MAKE) --no-print-directory docs validate
	@$(MAKE) --no-print-directory colcon
	@echo "All slow checks hold."

# The tests marked as slow are those of test_slow.
SPEED := not slow

lint: environment ## ruff
	$(BIN)/ruff check .

# The newest numpy for Python 3.10 has older stubs than the code is typed against.
types: environment ## mypy --strict, on Python 3.11 and later
	@if $(BIN)/python -c 'import sys; sys.exit(sys.version_info < (3, 11))'; then $(BIN)/mypy; \
	else echo "Types are checked on Python 3.11 and later only."; fi

compiled: environment ## The kernels of the dry and the oiled benches, so that not every test process compiles them for itself
	$(BIN)/python -c 'from dcrb_ros import Simulation as S, load_configuration as c; [next(S(c(name)).blocks()) for name in ("dry", "healthy")]'

architecture: environment ## The import contracts of pyproject.toml
	$(BIN)/lint-imports --no-logo

unit: environment ## The tests without ROS processes, file by file on two cores (SPEED=slow for the slow ones)
	$(BIN)/python -m pytest -m "not node and $(SPEED)" -n 2 --dist loadfile

kernels: environment ## The laws of the kernels once more, without the compiler
	NUMBA_DISABLE_JIT=1 $(BIN)/python -m pytest tests/core -m kernel

# A failure is final. Twice, rclpy's destroy_node crashed a test process while a client left the graph of killed nodes, the second time in its
# last step, which ends the DDS participant; 140 provoked closings did not repeat it. So the tests whose process crashed (exit status 9,
# tests/support/crashed_workers.py) are run once more.
nodes: environment compiled ## The tests that start ROS nodes (SPEED=slow for the slow ones)
	@status=0; PYTHONPATH=tests/support $(BIN)/python -m pytest tests/nodes -m "node and $(SPEED)" -n 2 --dist worksteal -p crashed_workers || status=$$?; \
	if [ $$status -eq 9 ]; then $(BIN)/python -m pytest tests/nodes -m "node and $(SPEED)" --last-failed --last-failed-no-failures none; \
	else exit $$status; fi

validate: environment ## The paper's numbers and figures: a table, and a report in validation/
	$(BIN)/dcrb validate -o validation

bench: environment ## Speed, starts, growth and memory, half an hour: rewrites docs/results/performance.md (BENCH='start scaling' for parts)
	$(BIN)/python benchmarks/performance.py $(BENCH)

MEASURED ?= ../shared/measured
sim_to_real: environment ## Train on simulated bearings, test on measured ones in MEASURED, an hour (SIM_TO_REAL='--machines 64 --seconds 8')
	$(BIN)/python benchmarks/sim_to_real.py $(MEASURED) $(SIM_TO_REAL)

predictivity: environment ## Compare replicas of the recordings in MEASURED with them, hours on two cores: rewrites docs/results/predictivity.md (PREDICTIVITY='--workers 8', or '--leaderboard docs/leaderboard' for its entries in seconds)
	$(BIN)/python benchmarks/predictivity.py $(MEASURED) $(PREDICTIVITY)

soak: environment ## An hour flat out and ten minutes in real time, with random commands and faults (SOAK='--flat-out 60 ...')
	$(BIN)/python benchmarks/soak.py $(SOAK)

signals: environment ## SIGINT, SIGTERM and kill -9 at 100 random instants, a quarter of an hour (SIGNALS='--runs 20 --seed 7')
	$(BIN)/python benchmarks/signals.py $(SIGNALS)

exam: environment ## The exams of the shipped detector, and of the naive one: rewrites docs/results/exam.md (EXAM=hours for the healthy hours)
	$(BIN)/python benchmarks/exam.py $(EXAM)

hot_boxes: environment ## Lead times of the detector before wayside hot-box detectors, some ten minutes (HOT_BOXES='--healthy 4 --faulty 40')
	$(BIN)/python benchmarks/hot_boxes.py --figure hot-boxes.png $(HOT_BOXES)

mutants: environment ## Do the tests notice slips? A sample of mutants of each package, some hours (MUTANTS='core --sample 20')
	$(BIN)/python -m pip install --quiet --disable-pip-version-check 'cosmic-ray>=8.7,<9'
	$(BIN)/python tests/mutants/run.py $(MUTANTS)

hostile: environment compiled ## All hostile inputs: files, command lines, messages, parameters; make test runs a part
	DCRB_HOSTILE=all $(BIN)/python -m pytest tests/hostile

pictures: environment ## Make pictures of the documentation (PICTURES='rerun order-map'); without names, list those that are out of date
	MEASURED=$(MEASURED) $(BIN)/python benchmarks/pictures.py $(PICTURES)

docs: environment ## The site, into site/, some two minutes: two notebooks are executed, except in make test
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

colcon: environment ## Build and test as a ROS package
	.ci/colcon

clean: ## Remove what was made, the cache of compiled kernels included, but not the recordings
	@if [ -x $(BIN)/dcrb ]; then $(BIN)/dcrb cache --clear; else echo "Without .venv the caches stay; they are in ~/.cache/dcrb_ros."; fi
	rm -rf .venv build install log site validation dcrb_ros.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
