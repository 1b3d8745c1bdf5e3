# Everything runs in a virtual environment of its own; `make run` and `make test` need only Python >= 3.11 and make.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
BENCH := $(VENV)-bench/bin
BENCH_STAMP := $(VENV)-bench/.installed
DOCS := $(VENV)-docs/bin
DOCS_STAMP := $(VENV)-docs/.installed
REFERENCE := data/reference/gyroscopic_disk_very_light

.PHONY: run test test-first test-second lint bench bench-quick docs clean

# the very light stator of the paper's Figures 3 (right) and 4: run-up, run-down, and both in one picture
run: $(STAMP)
	$(BIN)/rsc check $(REFERENCE).toml --output out/run_up
	$(BIN)/rsc check $(REFERENCE)_rundown.toml --output out/run_down
	$(BIN)/rsc plot out/run_up/result.h5 out/run_down/result.h5 --output out/both
	@echo "pictures: out/run_up/*.png, out/run_down/*.png, both runs: out/both/amplitude.png"

# two processes of about equal length at a time; they share nothing but the kernel cache, which is made for it
FIRST := $(wildcard tests/test_[a-k]*.py) tests/test_wide.py
SECOND := $(filter-out $(FIRST),$(wildcard tests/test_*.py))

test: lint
	$(MAKE) --no-print-directory --jobs=2 test-first test-second

test-first: $(STAMP)
	$(BIN)/python -m pytest -p no:cacheprovider $(FIRST)

test-second: $(STAMP)
	$(BIN)/python -m pytest -p no:cacheprovider $(SECOND)

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

# the site, out/site/index.html; a broken link or reference fails
docs: $(DOCS_STAMP)
	$(DOCS)/python tools/scene_reference.py --check
	$(DOCS)/sphinx-build -q -W --keep-going -b html docs out/site
	@echo "site: out/site/index.html"

$(STAMP): pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --editable ".[dev]"
	touch $@

$(BENCH_STAMP): pyproject.toml
	$(PYTHON) -m venv $(VENV)-bench
	$(BENCH)/python -m pip install --quiet --editable ".[dev,bench]"
	$(BENCH)/python -m pip install --quiet numbalsoda 2>/dev/null || echo "numbalsoda stays absent: its source needs a Fortran compiler"
	touch $@

$(DOCS_STAMP): pyproject.toml
	$(PYTHON) -m venv $(VENV)-docs
	$(DOCS)/python -m pip install --quiet --editable ".[docs]"
	touch $@

clean:
	rm -rf $(VENV) $(VENV)-bench $(VENV)-docs out
