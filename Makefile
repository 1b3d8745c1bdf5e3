# Everything runs in a virtual environment of its own; `make run` and `make test` need only Python >= 3.11 and make.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
BENCH := $(VENV)-bench/bin
BENCH_STAMP := $(VENV)-bench/.installed
REFERENCE := data/reference/gyroscopic_disk_very_light

.PHONY: run quick test nightly lint bench bench-quick clean

# the very light stator of the paper's Figures 3 (right) and 4: run-up, run-down, and both in one picture
run: $(STAMP)
	$(BIN)/rsc check $(REFERENCE).toml --output out/run_up
	$(BIN)/rsc check $(REFERENCE)_rundown.toml --output out/run_down
	$(BIN)/rsc plot out/run_up/result.h5 out/run_down/result.h5 --output out/both
	@echo "pictures: out/run_up/*.png, out/run_down/*.png, both runs: out/both/amplitude.png"

# what compiles no kernel, or the one that a run of tests/support/scenes.py's first scene needs; pytest refuses a path that is gone
QUICK := $(addprefix tests/, unit/test_house.py unit/test_seeded_bugs.py unit/scene unit/measure unit/system \
	unit/kernel/test_tableau.py unit/kernel/test_kernel.py unit/results/test_bad_result_files.py unit/cli/test_bad_commands.py \
	unit/analysis/test_analytic.py unit/analysis/test_eigenvalues.py unit/analysis/test_predict.py laws/test_limits.py \
	literature/test_reference_data.py)
# two processes; a file stays in one of them, because its tests share fixtures and compiled variants of the kernel
PYTEST = $(BIN)/python -m pytest -p no:cacheprovider --numprocesses=2 --dist=loadfile

# three tiers: while working; before a commit and in CI; before a release, some hours
quick: lint
	$(PYTEST) -m "not nightly" $(QUICK)

test: lint
	$(PYTEST) -m "not nightly"

nightly: $(STAMP)
	$(PYTEST) -m nightly
	$(BIN)/python tools/fuzz.py
	$(BIN)/python tools/faults.py
	$(BIN)/python tools/tiny_cases.py
	$(BIN)/python tools/seeded_bugs.py --jobs 2

lint: $(STAMP)
	$(BIN)/ruff check src tests bench tools
	$(BIN)/lint-imports --no-cache

# every measurement of docs/kernel.md and the README; CSV and PNG under bench/results/, how long it took in duration.txt
bench: $(BENCH_STAMP)
	@mkdir -p out && date +%s > out/bench_began
	$(BENCH)/python bench/work_precision.py
	$(BENCH)/python bench/dozen.py
	$(BENCH)/python bench/maps.py
	$(BENCH)/python bench/physics.py
	$(BENCH)/python bench/ensemble.py
	$(BENCH)/python -m pytest bench/suite --benchmark-only --benchmark-json=bench/results/suite.json
	@echo "make bench: $$(( ($$(date +%s) - $$(cat out/bench_began) + 59) / 60 )) min on $$(getconf _NPROCESSORS_ONLN) cores," \
		"commit $$(git rev-parse --short HEAD), $$(date -u +%F)" | tee bench/results/duration.txt

# the same on a few short points into out/bench/, to see that everything still runs: nothing is timed in earnest, absent peers are listed as absent
bench-quick: $(STAMP)
	$(BIN)/python bench/work_precision.py --quick
	$(BIN)/python bench/dozen.py --quick
	$(BIN)/python bench/maps.py --quick
	$(BIN)/python bench/physics.py --quick
	$(BIN)/python bench/ensemble.py --quick

$(STAMP): pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --editable ".[dev]"
	touch $@

$(BENCH_STAMP): pyproject.toml
	$(PYTHON) -m venv $(VENV)-bench
	$(BENCH)/python -m pip install --quiet --editable ".[dev,bench]"
	$(BENCH)/python -m pip install --quiet numbalsoda 2>/dev/null || echo "numbalsoda stays absent: its source needs a Fortran compiler"
	touch $@

clean:
	rm -rf $(VENV) $(VENV)-bench out
