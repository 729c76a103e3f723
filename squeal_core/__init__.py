"""Online eigen-stability of disc brakes: the model, its stability and the monitor; no ROS."""

from squeal_core import stability
from squeal_core.brake_model import BrakeModel
from squeal_core.errors import SquealError
from squeal_core.operating_point import OperatingPoint

__version__ = '0.1.0'  # the one place: pyproject.toml reads it, a test holds package.xml to it

__all__ = ['BrakeModel', 'OperatingPoint', 'SquealError', '__version__', 'stability']
