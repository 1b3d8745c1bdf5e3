# Everything runs in a virtual environment of its own; `make run` and `make test` need only Python >= 3.11 and make.
PYTHON ?= python3
# what a release is tested with; tools/versions.py tries older and newer libraries
CONSTRAINTS := constraints.txt
VENV := .venv
# Windows' virtual environments have their programs in another folder
PROGRAMS := $(if $(filter Windows_NT,$(OS)),Scripts,bin)
BIN := $(VENV)/$(PROGRAMS)
RUN_STAMP := $(VENV)/.runs
STAMP := $(VENV)/.installed
BENCH := $(VENV)-bench/$(PROGRAMS)
BENCH_STAMP := $(VENV)-bench/.installed
DOCS := $(VENV)-docs/$(PROGRAMS)
DOCS_STAMP := $(VENV)-docs/.installed
REFERENCE := data/reference/gyroscopic_figure3

# byte code is kept whatever the shell says: the tests start hundreds of programs, and each would compile all sources anew
unexport PYTHONDONTWRITEBYTECODE

.PHONY: run paper browser quick test nightly lint release versions bench bench-quick stability docs clean

# the paper's Figures 3 right and 4, and with a smaller gap 3 left, from one rotor
run: $(RUN_STAMP)
	$(BIN)/rsc check $(REFERENCE)_right.toml --output out/figure3_right
	$(BIN)/rsc check $(REFERENCE)_left.toml --output out/figure3_left
	@echo "reports: out/figure3_right/report.html, out/figure3_left/report.html"

# the paper's Figures 3 to 6 and the numbers of its text: bench/results/paper.md and paper_*.png, in a minute
paper: $(RUN_STAMP)
	$(BIN)/python bench/paper.py

# Debian's Chromium, in which test_page_browser.py opens report.html; where it cannot be had these tests are skipped and say so
browser:
	@command -v chromium >/dev/null || { timeout 120 apt-get -qq update && DEBIAN_FRONTEND=noninteractive timeout 300 apt-get -qq install -y \
		--no-install-recommends chromium >/dev/null; } || echo "no Chromium: tests of report.html in a browser are skipped"

# what compiles no kernel, or the one that a run of tests/support/scenes.py's first scene needs; pytest refuses a path that is gone
QUICK := $(addprefix tests/, $(addprefix unit/house/test_, house.py seeded_bugs.py citations.py glossary.py named_in_documents.py) \
	unit/scene unit/units unit/measure unit/system \
	unit/kernel/test_tableau.py unit/kernel/test_kernel.py unit/results/test_bad_result_files.py unit/cli/test_bad_commands.py \
	unit/analysis/test_analytic.py unit/analysis/test_eigenvalues.py unit/analysis/test_predict.py laws/test_limits.py \
	literature/test_reference_data.py)
# two processes; a file stays in one of them, because its tests share fixtures and compiled variants of the kernel; in the order of
# their names, so that long files with few tests do not come last
PYTEST = $(BIN)/python -m pytest -p no:cacheprovider --numprocesses=2 --dist=loadfile --no-loadscope-reorder

# three tiers: while working; before a commit and in CI; before a release, some hours
quick: lint
	$(PYTEST) -m "not nightly" $(QUICK)

test: lint
	$(PYTEST) -m "not nightly"

nightly: $(STAMP)
	$(PYTEST) -m nightly
	$(BIN)/python tools/fuzz.py
	$(BIN)/python tools/forged.py
	$(BIN)/python tools/bombs.py
	$(BIN)/python tools/faults.py
	$(BIN)/python tools/faults.py --sweeps
	$(BIN)/python tools/faults.py --memory --share 0.02
	$(BIN)/python tools/bounds.py
	$(BIN)/python tools/covered.py
	$(BIN)/python tools/tiny_cases.py
	$(BIN)/python tools/notebooks.py --run
	$(BIN)/python tools/seeded_bugs.py --jobs 2

# before a version is cut: short tests, documents, version and date, two builds with equal bytes, the wheel in a new environment
release: quick docs
	$(BIN)/python -m pip install --quiet --editable ".[release]"
	$(BIN)/python tools/release.py

# short suite on the declared lower bounds of all libraries, the newest, Numba alone, later Pythons; the table: bench/results/versions.txt
versions: $(STAMP)
	$(BIN)/python tools/versions.py

# types on both platforms at once, each with a cache of its own
lint: $(STAMP)
	$(BIN)/ruff check src tests bench tools
	$(BIN)/lint-imports --no-cache
	@$(BIN)/mypy --platform win32 --cache-dir .mypy_cache/windows & windows=$$!; $(BIN)/mypy; here=$$?; wait $$windows && exit $$here

# the measurements of docs/maintainers/kernel.md and the README; CSV and PNG under bench/results/, how long it took in duration.txt
bench: $(BENCH_STAMP)
	@mkdir -p out && date +%s > out/bench_began
	$(BENCH)/python bench/work_precision.py
	$(BENCH)/python bench/ensemble.py
	$(BENCH)/python bench/sweep.py
	$(BENCH)/python bench/main_job.py --long --write
	$(BENCH)/python bench/energy.py --write
	$(BENCH)/python -m pytest bench/suite --benchmark-only --benchmark-timer=time.process_time --benchmark-json=bench/results/suite.json
	$(BENCH)/python bench/coordinates_picture.py
	@echo "make bench: $$(( ($$(date +%s) - $$(cat out/bench_began) + 59) / 60 )) min on $$(getconf _NPROCESSORS_ONLN) cores," \
		"commit $$(git rev-parse --short HEAD), $$(date -u +%F)" | tee bench/results/duration.txt

# the same on a few short points into out/bench/, to see that everything still runs: nothing is timed in earnest, absent peers are listed as absent
bench-quick: $(STAMP)
	$(BIN)/python bench/work_precision.py --quick
	$(BIN)/python bench/ensemble.py --quick
	$(BIN)/python bench/sweep.py --quick
	$(BIN)/python bench/main_job.py --quick
	$(BIN)/python bench/energy.py --quick
	$(BIN)/python bench/stability/dozen.py --quick
	$(BIN)/python bench/stability/maps.py --quick
	$(BIN)/python bench/stability/physics.py --quick
	$(BIN)/python bench/stability/internal_resonance.py --quick

# where methods fail, what a tolerance does to a jump and to chaos, censuses of roots and stability: docs/users/performance.md
stability: $(STAMP)
	$(BIN)/python bench/stability/dozen.py
	$(BIN)/python bench/stability/maps.py
	$(BIN)/python bench/stability/physics.py
	$(BIN)/python bench/stability/internal_resonance.py --write
	$(BIN)/python bench/stability/roots_census.py --write
	$(BIN)/python bench/stability/stability_census.py --write

# the site, out/site/index.html; a broken link or reference fails
docs: $(DOCS_STAMP)
	$(DOCS)/python tools/scene_reference.py --check
	$(DOCS)/python tools/command_reference.py --check
	$(DOCS)/sphinx-build -q -W --keep-going -b html docs out/site
	@echo "site: out/site/index.html"

# what rsc itself needs
$(RUN_STAMP): pyproject.toml $(CONSTRAINTS)
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --editable . --constraint $(CONSTRAINTS)
	touch $@

# and what its tests need
$(STAMP): $(RUN_STAMP)
	$(BIN)/python -m pip install --quiet --editable ".[dev]" --constraint $(CONSTRAINTS)
	touch $@

$(BENCH_STAMP): pyproject.toml
	$(PYTHON) -m venv $(VENV)-bench
	$(BENCH)/python -m pip install --quiet --editable ".[dev,bench]"
	@command -v gfortran >/dev/null || { timeout 120 apt-get -qq update && DEBIAN_FRONTEND=noninteractive timeout 300 apt-get -qq install -y \
		--no-install-recommends gfortran g++ >/dev/null; } || echo "no Fortran compiler"
	$(BENCH)/python -m pip install --quiet numbalsoda 2>/dev/null || echo "numbalsoda stays absent: its source needs a Fortran compiler"
	touch $@

$(DOCS_STAMP): pyproject.toml
	$(PYTHON) -m venv $(VENV)-docs
	$(DOCS)/python -m pip install --quiet --editable ".[docs]"
	touch $@

clean:
	rm -rf $(VENV) $(VENV)-bench $(VENV)-docs out
