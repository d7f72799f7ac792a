# `make run` and `make test` set up everything they need in .venv. Another Python: make clean run PYTHON=python3.12
VENV := .venv
BIN := $(VENV)/bin
PYTHON ?=
# An environment that was moved or copied here leads to where it was made, without a word: it is made again.
MADE_AT := $(shell sed -n -e '1s,^\#!\(/.*/\)python[^/]*$$,\1,p' -e 's,^made_at="\(.*\)"$$,\1,p' $(VENV)/bin/heave 2>/dev/null)
ifneq ($(MADE_AT),)
ifneq ($(shell [ "$(MADE_AT)" -ef $(VENV)/bin/ ] && echo here),here)
$(info setup: $(VENV) was made at $(MADE_AT) and moved: it is made again)
$(shell rm -rf $(VENV))
endif
endif
# What a build copies; Python files, scenarios among them, are used where they lie.
BUILD_INPUTS := pyproject.toml $(wildcard cmake/* core/*.cmake core/heave_core/src/* core/heave_core/*.py msgs/*.txt msgs/*.xml msgs/msg/* msgs/srv/* msgs/action/* */package.xml */launch/* */config/*)

# The mark that the ROS wheels leave in the environment belongs to one Python; another must set itself up.
unexport _ROS_WHEELS_BOOTSTRAP_COMPLETE
# An installed ROS 2 that this shell has sourced must not mix with the wheels.
unexport PYTHONPATH AMENT_PREFIX_PATH CMAKE_PREFIX_PATH LD_LIBRARY_PATH
# What is imported while the models are compiled leaves its bytecode; that of libraries' tests is never needed.
unexport PYTHONDONTWRITEBYTECODE
export OMP_NUM_THREADS ?= 1
export PIP_DISABLE_PIP_VERSION_CHECK ?= 1
# Trust the certificates that the machine trusts, as pip and git do.
export UV_NATIVE_TLS ?= 1

# The versions that were tested with the Python of .venv, where there is a file of them; LATEST=1 takes the newest instead.
PINS = $(if $(LATEST),,$(wildcard constraints/$(shell $(BIN)/python -c 'import sys; print("python%d.%d" % sys.version_info[:2])').txt))
PINNED = $(if $(PINS),UV_CONSTRAINT=$(CURDIR)/$(PINS) UV_BUILD_CONSTRAINT=$(CURDIR)/$(PINS) PIP_CONSTRAINT=$(CURDIR)/$(PINS))
# What takes a minute says every 15 s that it goes on.
TELLING := sh tools/patiently.sh

.PHONY: help run extras test validate mutants bench style lint docs gallery coverage install constraints clean
.DELETE_ON_ERROR:

help:  ## what can be made
	@sed -n 's/^\([a-z]*\):.*## */make \1\t/p' $(MAKEFILE_LIST)

run: $(VENV)/.installed  ## set up, then the calm-sea scenario for ten simulated minutes: a bag and a report under runs/
	$(BIN)/heave run b2_calm_300 --duration 600

test: style  ## set up, then every check: ruff, then mypy among the tests, on two cores
	$(BIN)/python -m pytest --numprocesses 2 --dist loadfile --no-loadscope-reorder $(PYTEST)

validate: $(VENV)/.test-installed  ## the longest tests, and campaigns of five hours or more: 1,000 faults in all modes, 192 draws of the day of the promise, 1,000 damaged bags, 1,000 hostile files, 100 killed runs, 200 interrupted studies, 1,000 storms, 200 answers of what would have been, 15 simulated hours and a real one
	$(BIN)/python -m pytest -m long
	$(BIN)/python -m tests.campaigns.fault_matrix --cases 1000 --workers 2
	$(BIN)/heave study few --draws 64
	$(BIN)/heave study stacked --draws 64
	$(BIN)/heave study seas --draws 32
	$(BIN)/heave study lifts --draws 32
	$(BIN)/python -m tests.campaigns.damaged_bags
	$(BIN)/python -m tests.campaigns.hostile_files
	$(BIN)/python -m tests.campaigns.killed_processes
	$(BIN)/python -m tests.campaigns.interrupted_studies
	$(BIN)/python -m tests.campaigns.storms
	$(BIN)/python -m tests.campaigns.whatif
	$(BIN)/python -m tests.campaigns.soak

mutants: $(VENV)/.test-installed  ## change the modules that safety rests on, one small thing at a time, and count what no test notices: two hours or three; MUTANTS="--only guard --sample 50" tries a part
	$(BIN)/python -m tests.campaigns.mutants $(MUTANTS)

bench: $(VENV)/.test-installed  ## how fast the suite is on this machine, beside its peers: plant, statics, loop, controller, recorder; BENCH="--only plant" measures a part
	$(BIN)/python -m benchmarks.bench $(BENCH)

style: $(VENV)/.test-installed  ## set up, then ruff
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

lint: style  ## set up, then ruff and mypy
	$(BIN)/mypy

coverage: $(VENV)/.test-installed  ## the tests with the lines they reach
	@$(PINNED) VIRTUAL_ENV=$(CURDIR)/$(VENV) $(BIN)/uv pip install --quiet --requirement pyproject.toml --extra coverage
	$(BIN)/coverage run -m pytest $(PYTEST)
	$(BIN)/coverage combine --quiet || true
	$(BIN)/coverage report

docs: $(VENV)/.installed  ## the documentation site, into docs/site: open docs/site/index.html; needs no network once its tools are there
	@$(BIN)/python -c "import material" 2>/dev/null || $(PINNED) VIRTUAL_ENV=$(CURDIR)/$(VENV) $(BIN)/uv pip install --quiet --requirement pyproject.toml --extra docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs --quiet build --strict --config-file docs/mkdocs.yml
	@echo "docs/site/index.html"

gallery: $(VENV)/.test-installed  ## every figure of the validation, in ten minutes; `make docs` then shows them
	$(BIN)/python benchmarks/gallery.py docs/gallery

install: $(VENV)/.installed  ## set up only: .venv/bin/heave

constraints: $(VENV)/.test-installed  ## write the versions of this environment to constraints/, which run and test then take
	@sh tools/constraints.sh $(VENV) > constraints/.new
	@mv constraints/.new constraints/$$($(BIN)/python -c 'import sys; print("python%d.%d" % sys.version_info[:2])').txt
	@ls constraints

# uv installs in a third of pip's time; where it cannot (a mirror that only pip is told of) pip does.
$(VENV)/bin/uv:
	@python=$$(sh tools/find_python.sh $(PYTHON)) && echo "setup: $$python" && "$$python" -m venv --clear $(VENV)
	@$(BIN)/python -m pip install --quiet uv

# What no run uses goes: the middleware's copies of one library and, before there are extras, whose imports need theirs, C++
# headers and tests of libraries (100 MB).
$(VENV)/.installed: $(VENV)/bin/uv $(BUILD_INPUTS)
	@echo "setup: ROS 2 from wheels, then the messages are compiled: two to five minutes"
	@echo "setup: $(if $(PINS),the versions of $(PINS); the newest: make LATEST=1,the newest versions)"
	@$(PINNED) $(BIN)/python -m pip install --quiet --upgrade pip 'setuptools<80'
	@$(PINNED) VIRTUAL_ENV=$(CURDIR)/$(VENV) $(TELLING) "ROS 2 and the messages" $(BIN)/uv pip install --quiet --reinstall-package heave --editable . || \
		$(PINNED) $(TELLING) "ROS 2 and the messages, by pip" $(BIN)/python -m pip install --quiet --editable .
	@sh tools/launcher.sh $(VENV)
	@echo "setup: compiling the models, once"
	@$(TELLING) "compiling the models" $(BIN)/python -m heave_bringup.compiled > $(VENV)/models.log 2>&1 || \
		echo "setup: left to the first run, which will start slowly; $(VENV)/models.log says why"
	@cd $(VENV)/lib && for copy in libfastdds.so libfastdds.so.3.2; do ! cmp -s $$copy libfastdds.so.3.2.2 || ln -sf libfastdds.so.3.2.2 $$copy; done
	@[ -e $@ ] || { rm -rf $(VENV)/include && find $(VENV)/lib/python*/site-packages -type d -name tests -prune -exec rm -rf {} +; }
	@touch $@

$(VENV)/.test-installed: $(VENV)/.installed
	@$(PINNED) VIRTUAL_ENV=$(CURDIR)/$(VENV) $(TELLING) "what the tests need" $(BIN)/uv pip install --quiet --requirement pyproject.toml --extra test || \
		$(PINNED) $(TELLING) "what the tests need, by pip" $(BIN)/python -m pip install --quiet --editable '.[test]'
	@touch $@

extras: $(VENV)/.installed  ## set up, then every extra: studies, devices, statics, panel, FMUs
	@$(PINNED) VIRTUAL_ENV=$(CURDIR)/$(VENV) $(TELLING) "the extras" $(BIN)/uv pip install --quiet --requirement pyproject.toml --extra all
	@echo "setup: extras installed: design, studies, devices, statics, panel, FMUs"

clean:  ## remove the environment and what was built; runs/ stays
	rm -rf $(VENV) build install log dist
