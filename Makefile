# `make demo` and `make test` do all the set-up themselves: an environment in .venv, made once.
SHELL := /bin/bash
VENV := .venv
BIN := $(VENV)/bin
# the first interpreter that is new enough; or say which: make demo PYTHON=/path/to/python3.12
PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.11 python3.14; do \
	$$p -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 14))' 2>/dev/null \
	&& echo $$p && break; done)

.PHONY: demo test lint benchmark clean help

help:  ## list the targets
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*## /\t/' | expand -t 14

demo: $(VENV)/installed  ## node, player and replay of a drive, end to end; plot in demo_output/
	@$(BIN)/squeal demo

test: $(VENV)/installed  ## all tests
	$(BIN)/python -m pytest -n 2 --dist loadfile

lint: $(VENV)/installed  ## ruff and mypy
	$(BIN)/ruff check .
	$(BIN)/mypy

benchmark: $(VENV)/installed  ## timings, printed
	$(BIN)/python benchmark/full_solve.py

clean:  ## remove the environment and what was made
	rm -rf $(VENV) demo_output build install log *.egg-info

$(VENV)/installed: setup.py
	@test -n "$(PYTHON)" || { echo 'make: no Python 3.11 to 3.14 found; install one, or say' \
		'which: make demo PYTHON=/path/to/python3.12' >&2; exit 1; }
	@$(PYTHON) -m venv $(VENV) || { echo 'make: no environment: $(PYTHON) lacks venv (Debian,' \
		'Ubuntu: apt install python3-venv)' >&2; rm -rf $(VENV); exit 1; }
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[all]'
	@touch $@
