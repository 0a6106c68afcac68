# One target a job; CI runs `make lint` and `make test`.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
# other packages, in an environment of their own
PEERS  := target/peers

.PHONY: test test-rust test-python test-browser lint deny fuzz wheel blind blind-short plan coverage findings staged bench bench-door pictures clean

# The wheel of the tests is made of the objects that the Rust tests have built; that of the benches as users get it.
test test-python test-browser: PROFILE := dev
# and has a panic on demand, which no published wheel has
test test-python test-browser: FEATURES := --features panics

test: test-rust test-python test-browser

test-rust:
	cargo test --workspace --all-targets
	cargo test --workspace --doc

$(BIN)/python:
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip

# The wheel is built and installed as a user would, in an environment of its own.
PROFILE ?= release
wheel: $(BIN)/python
	MATURIN_PEP517_ARGS="--profile $(PROFILE) $(FEATURES)" $(BIN)/python -m pip install --quiet './python[test]'

test-python: wheel
	cd python && ../$(BIN)/python -m pytest -n logical
	cd python && ../$(BIN)/python -m mypy
	cd python && ../$(BIN)/python -m mypy.stubtest hydrosysid --allowlist stubtest.txt

# Report and page in a headless Chromium; skipped where there is none, unless CI is set.
test-browser: wheel
	$(BIN)/python -m pytest -p no:cacheprovider -n logical tests/browser

lint: $(BIN)/python
	cargo fmt --all -- --check
	cargo clippy --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --quiet
	@crates=$$(cargo tree --package hydrosysid --no-default-features --edges normal --prefix none --no-dedupe | sort -u | wc -l); \
	echo "the core stands on $$crates crates, itself among them (under 90)"; test $$crates -lt 90
	$(BIN)/python -m pip install --quiet ruff
	$(BIN)/ruff format --check python
	$(BIN)/ruff check python

# Licences, advisories and duplicates of what is built in; needs cargo-deny.
deny:
	cargo deny check

# Each fuzz target for a while; needs cargo-fuzz and a nightly toolchain. See fuzz/README.md.
SECONDS_EACH ?= 300
fuzz:
	fuzz/seed.sh
	for target in log campaign fit; do \
		cargo +nightly fuzz run $$target -- -max_total_time=$(SECONDS_EACH) -timeout=1 -max_len=65536 || exit 1; \
	done

# The table of hits, misses and false names over hidden effects; see docs/blind.md.
blind:
	cargo run --release --example blind -- --write docs/blind.md

$(PEERS)/bin/python: benches/peers/requirements.txt
	$(PYTHON) -m venv $(PEERS)
	$(PEERS)/bin/python -m pip install --quiet -r benches/peers/requirements.txt
	touch $@

# The same over two seeds a row, printed and not written.
blind-short:
	cargo run --release --example blind -- --seeds 2

# The table of plans against simulated campaigns; see docs/plan.md.
plan:
	cargo run --release --example plan -- --write docs/plan.md

# Intervals against the truth, errors against the Cramér-Rao bound; see docs/coverage.md.
coverage:
	cargo run --release --example coverage -- --write docs/coverage.md

# What `check` says of logs with faults, and of sound ones; see docs/findings.md.
findings:
	cargo run --release --example findings -- --write docs/findings.md

# The table of the staged procedure against the truth over fifty seeds; see docs/staged.md.
staged:
	cargo run --release --example staged -- --write docs/staged.md

# Time of our parts, and of others on the same work; see docs/benchmarks.md.
bench: wheel $(PEERS)/bin/python
	cargo build --release
	cargo bench --bench first_look
	cargo bench --bench parts --bench least_squares | tee target/parts.txt
	cargo bench --no-run --bench partner --bench growth --message-format=json > target/benches.json
	built() { sed -n "s/.*\"name\":\"$$1\".*\"executable\":\"\([^\"]*\)\".*/\1/p" target/benches.json; } && \
	$(PEERS)/bin/python benches/peers/run.py "$$(built partner)" "$$(built growth)" target/release/hydrosysid $(BIN)/python \
		--parts target/parts.txt --write docs/benchmarks.md

# The section of the Python package alone, put into the same page.
bench-door: wheel
	cargo bench --no-run --bench partner --message-format=json > target/benches.json
	partner=$$(sed -n 's/.*"name":"partner".*"executable":"\([^"]*\)".*/\1/p' target/benches.json) && \
	$(BIN)/python benches/peers/door.py "$$partner" $(BIN)/python docs/benchmarks.md

# The pictures of the book: terminal, report, page, notebook; see docs/pictures/make.py. Needs Chromium.
pictures: wheel
	cargo build --release
	$(BIN)/python docs/pictures/make.py target/release/hydrosysid

clean:
	cargo clean
	rm -rf $(VENV)
