# Everything runs in a virtual environment of its own; `make run` and `make test` need only Python >= 3.11 and make.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
REFERENCE := data/reference/gyroscopic_disk_very_light

.PHONY: run test lint bench clean

# the very light stator of the paper's Figures 3 (right) and 4: run-up, run-down, and both in one picture
run: $(STAMP)
	$(BIN)/rsc check $(REFERENCE).toml --output out/run_up
	$(BIN)/rsc check $(REFERENCE)_rundown.toml --output out/run_down
	$(BIN)/rsc plot out/run_up/result.h5 out/run_down/result.h5 --output out/both
	@echo "pictures: out/run_up/*.png, out/run_down/*.png, both runs: out/both/amplitude.png"

test: lint
	$(BIN)/python -m pytest

lint: $(STAMP)
	$(BIN)/ruff check src tests bench tools
	$(BIN)/lint-imports --no-cache

# error against running time of the kernel and a textbook Numba kernel; CSV under bench/results/
bench: $(STAMP)
	$(BIN)/python bench/speed.py --label core

$(STAMP): pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --editable ".[dev]"
	touch $@

clean:
	rm -rf $(VENV) out
