"""Entry points of the two programs: signals are in hand before anything slow is imported."""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

import sys

from squeal_ros import interrupts


def squeal() -> int:
    """Run the command `squeal`."""
    interrupts.EndAtOnce(130, 'squeal: interrupted')
    from squeal_ros.cli import main
    code = main()
    interrupts.ignore()
    return code


def monitor() -> int:
    """Run the node `squeal_monitor`."""
    interrupts.EndAtOnce(0, always=True)
    try:
        from squeal_ros.node import main
    except ModuleNotFoundError as error:
        print(f'squeal_monitor: {error}; source the setup of ROS 2 Jazzy, or '
              "pip install -e '.[ros]' in the checkout", file=sys.stderr)
        return 2
    code = main()
    interrupts.ignore()
    return code
