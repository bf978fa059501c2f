"""Executable `compass_driver`; its node is in the module of the same name with `_node`."""

from __future__ import annotations

import sys

from dead_reckoning.nodes.run import run


def main() -> int:
    """Run the node."""
    return run('dead_reckoning.nodes.compass_driver_node')


if __name__ == '__main__':
    sys.exit(main())
