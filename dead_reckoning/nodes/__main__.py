"""Run a node where no executable is installed: ``python -m dead_reckoning.nodes integrator``."""

from __future__ import annotations

import sys

from dead_reckoning.nodes.run import run

if __name__ == '__main__':
    if len(sys.argv) < 2:
        sys.exit('name a node: python -m dead_reckoning.nodes NAME [ROS arguments]')
    sys.exit(run(sys.argv.pop(1)))
