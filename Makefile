# Everything a person types. `make` alone lists it.

CARGO ?= cargo
.DEFAULT_GOAL := help
.NOTPARALLEL:
.PHONY: help demo test format lint docs units check-shaders shaders assets pictures bench embed-bevy clean

help:
	@echo "make demo     install what is missing, build, and paint the pictures that demo/index.html shows"
	@echo "make test     install what is missing, and run every check: format, clippy, rustdoc, tests, shaders"
	@echo "make bench    measure the stages on this machine's GPU"
	@echo "make shaders  compile glsl/ to the SPIR-V that is checked in (after changing a shader)"
	@echo "make assets   make the models and paint strips in assets/ again"
	@echo "make pictures make the pictures of README.md again"
	@echo "make embed-bevy  build the plugin for Bevy, run it without a window, and check its pictures (takes long)"
	@echo "make clean    delete what was built"

demo:
	@scripts/setup demo
	$(CARGO) run --release --locked -- demo

test:
	@scripts/setup test
	@$(MAKE) --no-print-directory format lint docs units check-shaders
	@echo "make test: all checks passed"

format:
	$(CARGO) fmt --check

# The second line is what an embedder gets: no program, none of its dependencies.
lint:
	$(CARGO) clippy --locked --all-targets -- -D warnings
	$(CARGO) clippy --locked --no-default-features --lib -- -D warnings

docs:
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --locked --no-deps

units:
	$(CARGO) test --locked

check-shaders:
	@CARGO="$(CARGO)" scripts/shaders check

shaders:
	@CARGO="$(CARGO)" scripts/shaders write

assets:
	$(CARGO) run --release --locked --example make_assets -- assets

pictures:
	@CARGO="$(CARGO)" scripts/pictures

bench:
	@scripts/setup demo
	$(CARGO) bench --locked --bench ceilings --bench synthesis --bench techniques --bench metrics

# Outside of the tests, since Bevy takes long to build.
embed-bevy:
	@scripts/setup test
	cd examples/impasto_bevy && $(CARGO) run --locked --example head -- ../../target/embed-bevy --validate

clean:
	$(CARGO) clean
	rm -rf examples/impasto_bevy/target
