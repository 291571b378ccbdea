# `make demo` and `make test` are all there is to know; `make help` lists the rest.
JOBS ?= $(shell nproc)
PREFIX ?= /usr/local
OUT ?= out/demo
export JOBS RECORDING ARGS OUT

.PHONY: help build demo test lint docs peers fuzz soak install clean
.NOTPARALLEL:

help:
	@echo 'make demo      build, then simulate a town, detect, evaluate: a page with every figure in $(OUT)'
	@echo '               RECORDING=path: label that recording; ARGS="--trajectory F ...": more options of mapless detect'
	@echo 'make test      everything that is checked: formatting, lint, tests, sanitizers, the installed package'
	@echo 'make build     the release command alone: build/mapless'
	@echo 'make lint      formatting, layers, documents, clang-tidy'
	@echo 'make docs      the reference of the public headers: build/reference/index.html'
	@echo 'make peers     KISS-ICP beside our odometry and DUFOMap beside our detection, their tables into'
	@echo '               docs/notebook/odometry.md, docs/accuracy.md, docs/export.md; ARGS="--kitti DRIVE" for that drive too, in the odometry'
	@echo 'make fuzz      fuzz every reader of files for 60 s (Clang, libFuzzer); ARGS="SECONDS READER...": others'
	@echo 'make soak      one hour of detection at 10 Hz: memory, time per scan, open files; ARGS: see scripts/soak.py'
	@echo 'make install   library, headers and command to PREFIX ($(PREFIX))'
	@echo 'make clean     remove build and out'
	@echo 'JOBS=$(JOBS) is how many processes build and test at once. Missing Debian packages are installed.'

build:
	@scripts/install_dependencies.sh
	@cmake --preset release -DMAPLESS_BUILD_TESTS=OFF -DMAPLESS_BUILD_BENCHMARKS=OFF -DMAPLESS_BUILD_CHECKS=OFF
	@cmake --build --preset release -j $(JOBS)
	@ln -sfn release/apps/mapless/mapless build/mapless

demo: build
	@scripts/demo.sh

# The sanitizer builds, the linters and the installed package are tests of the one ctest run at the end.
test:
	@scripts/install_dependencies.sh test docs
	@cmake --preset release -DMAPLESS_BUILD_TESTS=ON -DMAPLESS_BUILD_BENCHMARKS=ON -DMAPLESS_BUILD_CHECKS=ON
	@cmake --build --preset release -j $(JOBS)
	@ln -sfn release/apps/mapless/mapless build/mapless
	@ctest --preset release -j $(JOBS)

lint:
	@scripts/install_dependencies.sh test docs
	@cmake --preset release -DMAPLESS_BUILD_TESTS=ON -DMAPLESS_BUILD_BENCHMARKS=ON -DMAPLESS_BUILD_CHECKS=ON
	@ctest --preset release -j $(JOBS) -R '^lint\.'

docs:
	@scripts/install_dependencies.sh docs
	@mkdir -p build
	@doxygen docs/Doxyfile

# Python packages of others, from PyPI, in a folder of their own; needs python3-venv.
peers: build
	@python3 -m venv build/peers/python
	@build/peers/python/bin/pip install --quiet -r benchmarks/peers/requirements.txt
	@build/peers/python/bin/python benchmarks/peers/compare_odometry.py $(ARGS) --write docs/notebook/odometry.md
	@build/peers/python/bin/python benchmarks/peers/compare_detection.py --write docs/accuracy.md
	@build/peers/python/bin/python benchmarks/peers/compare_maps.py --duration-s 8 --write docs/export.md

fuzz:
	@scripts/install_dependencies.sh fuzz
	@scripts/fuzz.sh $(ARGS)

soak: build
	@scripts/soak.py build/mapless $(ARGS)

install: build
	@cmake --install build/release --prefix $(PREFIX)

clean:
	rm -rf build out
