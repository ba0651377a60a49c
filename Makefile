# Everything a developer types; `make help` lists it.

SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.DELETE_ON_ERROR:
.DEFAULT_GOAL := help
.PHONY: help demo setup test test-rust test-python lint docs bench bench-peers bench-rust clean

# The interpreter that the environments are made with: 3.10 or newer.
PYTHON ?= python3
# Where the demo leaves its report.
OUT ?= report

VENV := .venv
BIN := $(VENV)/bin
DEMO_VENV := .venv-demo
DEMO_BIN := $(DEMO_VENV)/bin
EXTRAS := notebook,distributed,compressed,peers,dev
PIP := -m pip --disable-pip-version-check
LOGS := target/logs
# Processes that run the Python tests, each with pictures of its own in memory: up to a GiB.
TEST_WORKERS ?= logical --maxprocesses=4
RUST_SOURCES := Cargo.toml Cargo.lock $(shell find src -type f)
PYTHON_SOURCES := $(shell find python -type f -name '*.py*' -not -path '*/__pycache__/*')

help: ## list these targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## /{printf "  make %-12s %s\n", $$1, $$2}' $(firstword $(MAKEFILE_LIST))

# What the machine must bring; each line says what is missing and how to get it.
define NEEDS
@command -v cargo >/dev/null || { echo "make: cargo is missing: install Rust from https://rustup.rs and open a new shell" >&2; exit 2; }
@command -v cc >/dev/null || { echo "make: a C compiler (cc) is missing: apt-get install gcc, or xcode-select --install" >&2; exit 2; }
@command -v "$(PYTHON)" >/dev/null || { echo "make: $(PYTHON) is missing: install Python 3.10 or newer, or name yours: make $(MAKECMDGOALS) PYTHON=python3.12" >&2; exit 2; }
@"$(PYTHON)" -c 'import sys; sys.exit(sys.version_info < (3, 10))' || { echo "make: $(PYTHON) is $$("$(PYTHON)" -V 2>&1), but 3.10 or newer is needed: make $(MAKECMDGOALS) PYTHON=python3.12" >&2; exit 2; }
@"$(PYTHON)" -c 'import ensurepip, venv' 2>/dev/null || { echo "make: $(PYTHON) cannot make environments: apt-get install python3-venv" >&2; exit 2; }
endef

demo: $(DEMO_VENV)/.installed ## compare techniques on a bundled scene; prints the table, leaves report/
	$(DEMO_BIN)/shadowlab compare @courtyard --technique uniform --technique lispsm --resolution 512,1024,2048 \
	  --backend cpu --out "$(OUT)"

# The package alone, and without wgpu, since the demo draws with the embedded renderer: half the build time.
$(DEMO_VENV)/.installed: pyproject.toml README.md $(RUST_SOURCES) $(PYTHON_SOURCES)
	$(NEEDS)
	"$(PYTHON)" -m venv $(DEMO_VENV)
	MATURIN_PEP517_ARGS="--no-default-features --features python" $(DEMO_BIN)/python $(PIP) install .
	@touch $@

setup: $(VENV)/.built ## make .venv: release build, all extras; rebuilds what changed

$(VENV)/.installed: pyproject.toml
	$(NEEDS)
	"$(PYTHON)" -m venv $(VENV)
	$(BIN)/python $(PIP) install --quiet 'maturin>=1.9,<2'
	source $(BIN)/activate && maturin develop --release --extras $(EXTRAS)
	@touch $@

# Python files are used where they stand, so only the extension is built anew.
$(VENV)/.built: $(VENV)/.installed $(RUST_SOURCES)
	source $(BIN)/activate && maturin develop --release --skip-install
	@touch $@

test: setup ## everything it needs, then the Rust tests, then the Python tests
	@$(MAKE) --no-print-directory test-rust test-python
	@.ci/counts $(LOGS)/rust.log $(LOGS)/python.log

# The tests say "skipped: why" on standard error where an adapter is missing; SHADOWLAB_REQUIRE_ALL=1 makes that a failure.
test-rust:
	@mkdir -p $(LOGS)
	cargo test --no-fail-fast 2>&1 | tee $(LOGS)/rust.log

# Each worker begins with a run of neighbouring tests, so that what a file shares is mostly made once, and takes from the others
# when it is done.
test-python: setup
	@mkdir -p $(LOGS)
	$(BIN)/python -m pytest -n $(TEST_WORKERS) --dist worksteal --durations=10 2>&1 | tee $(LOGS)/python.log

# Two feature sets, the smallest and the largest; clippy and rustdoc share what they compile of the dependencies.
lint: export PYO3_PYTHON = $(abspath $(BIN)/python)
lint: setup ## format, clippy, rustdoc, ruff, mypy
	cargo fmt --check
	cargo clippy --all-targets --no-default-features -- -D warnings
	cargo clippy --all-targets --all-features -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --no-deps --document-private-items --all-features
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/python docs/generate.py --check

docs: setup ## write the generated tables of README.md anew
	$(BIN)/python docs/generate.py

bench: setup ## a row of compare beside its parts, samples, memory, filters beside OpenGL, scenes of many instances
	$(BIN)/python benches/row_cost.py
	$(BIN)/python benches/samples_cost.py
	$(BIN)/python benches/beside/memory.py
	-$(BIN)/python benches/beside/memory.py --backend gpu
	$(BIN)/python benches/filters.py
	$(BIN)/python benches/culled.py

# Programs that only the benches run beside this one, in an environment of their own. OGRE and OpenSceneGraph are compiled
# against Debian's packages libogre-1.12-dev and libopenscenegraph-dev; Open3D needs libusb-1.0-0.
PEERS_VENV := .venv-peers
$(PEERS_VENV)/.installed:
	$(NEEDS)
	"$(PYTHON)" -m venv $(PEERS_VENV)
	$(PEERS_VENV)/bin/python $(PIP) install --quiet 'mitsuba>=3.5' 'open3d>=0.18'
	@touch $@

bench-peers: setup $(PEERS_VENV)/.installed ## the same work here and in six other programs, side by side
	$(BIN)/python benches/beside

bench-rust: ## the kernels, with criterion
	cargo bench

clean: ## remove the environments and everything built
	rm -rf target $(VENV) $(DEMO_VENV) $(PEERS_VENV) report dist .pytest_cache .hypothesis .mypy_cache .ruff_cache
	rm -f python/shadowlab/_core*.so python/shadowlab/_core*.pyd
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
