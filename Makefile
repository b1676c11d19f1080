# Everything a person types. `make` alone lists it.

CARGO ?= cargo
.DEFAULT_GOAL := help
.NOTPARALLEL:
.PHONY: help demo test format lint docs units check-shaders shaders header capi assets pictures \
	wgpu-host embed-wgpu embed-bevy bench clean

help:
	@echo "make demo     install what is missing, build, and paint the pictures that demo/index.html shows"
	@echo "make test     install what is missing, and run every check: format, clippy, rustdoc, tests, shaders"
	@echo "make bench    measure the stages on this machine's GPU (whole frames, on all GPUs: impasto bench)"
	@echo "make shaders  compile glsl/ to the SPIR-V that is checked in (after changing a shader)"
	@echo "make capi     build the libraries for C, with their header, into target/capi/"
	@echo "make header   make include/impasto.h again (after changing src/capi)"
	@echo "make assets   make the models and paint strips in assets/ again"
	@echo "make pictures make the pictures of README.md again"
	@echo "make embed-wgpu  build and check the wgpu program that impasto paints into (examples/impasto_wgpu)"
	@echo "make embed-bevy  build and check the plugin for Bevy (examples/impasto_bevy); takes long"
	@echo "make clean    delete what was built"

# `impasto bench` tells which commit it was built from, with + if files had been changed; nothing, outside of git.
demo bench: export IMPASTO_COMMIT = $(shell git describe --always --exclude='*' --dirty=+ 2>/dev/null)

demo:
	@scripts/setup demo
	$(CARGO) run --release --locked -- demo

test:
	@scripts/setup test
	@$(MAKE) --no-print-directory format lint docs units check-shaders wgpu-host
	@echo "make test: all checks passed"

format:
	$(CARGO) fmt --check

# The second line is what an embedder gets: no program, none of its dependencies.
lint:
	$(CARGO) clippy --locked --all-targets --features capi -- -D warnings
	$(CARGO) clippy --locked --no-default-features --lib -- -D warnings

docs:
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --locked --no-deps --features capi

units:
	$(CARGO) test --locked --features capi

check-shaders:
	@CARGO="$(CARGO)" scripts/shaders check

shaders:
	@CARGO="$(CARGO)" scripts/shaders write

header:
	$(CARGO) run --locked --example make_header

# The crate itself is a Rust library only; what C links to is asked for here.
capi_folder := $(or $(CARGO_TARGET_DIR),target)

capi:
	$(CARGO) rustc --release --locked --lib --no-default-features --features capi --crate-type cdylib,staticlib
	@mkdir -p $(capi_folder)/capi
	@cp include/impasto.h $(capi_folder)/capi
	@for library in $(capi_folder)/release/libimpasto.so $(capi_folder)/release/libimpasto.dylib \
		$(capi_folder)/release/libimpasto.a; do \
		if [ -e $$library ]; then cp $$library $(capi_folder)/capi; fi; done
	@echo "$(capi_folder)/capi has what C programs include and link to"

assets:
	$(CARGO) run --release --locked --example make_assets -- assets

pictures:
	@CARGO="$(CARGO)" scripts/pictures

# A package of its own: wgpu is nothing that impasto depends on.
wgpu_host := $(or $(CARGO_TARGET_DIR),target)/impasto_wgpu

embed-wgpu:
	@scripts/setup test
	@$(MAKE) --no-print-directory wgpu-host

wgpu-host:
	$(CARGO) fmt --check --manifest-path examples/impasto_wgpu/Cargo.toml
	$(CARGO) run --locked --manifest-path examples/impasto_wgpu/Cargo.toml --target-dir $(wgpu_host) -- \
		--check $(wgpu_host)/pictures

# Another one, and outside of the tests, since Bevy takes long to build.
bevy_host := $(or $(CARGO_TARGET_DIR),target)/impasto_bevy

embed-bevy:
	@scripts/setup test
	$(CARGO) fmt --check --manifest-path examples/impasto_bevy/Cargo.toml
	$(CARGO) run --locked --manifest-path examples/impasto_bevy/Cargo.toml --target-dir $(bevy_host) --example head -- \
		$(bevy_host)/pictures --validate

bench:
	@scripts/setup demo
	$(CARGO) bench --locked --bench ceilings --bench synthesis --bench techniques --bench metrics
	@echo "make bench: done. Frames of the techniques, checked, on any number of GPUs:"
	@echo "    $(CARGO) run --release -- bench --devices all -o DIR"

clean:
	$(CARGO) clean
