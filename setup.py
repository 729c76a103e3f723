"""Installs by pip (extras by need) and by colcon (ament_python)."""

from glob import glob
from pathlib import Path
import re

from setuptools import find_packages, setup

HERE = Path(__file__).parent
PACKAGE = 'squeal_ros'
VERSION = re.search(r"__version__ = '(.+?)'",  # not imported: numpy may not be there yet
                    (HERE / 'squeal_core' / '__init__.py').read_text(encoding='utf-8'))[1]
SHARE = f'share/{PACKAGE}'
CONFIG = ('config', 'config/brakes', 'config/models', 'config/drive_cycles', 'config/vehicles',
          'config/layouts', 'config/security')

ROS = ['ros-jazzy-rclpy[fastrtps]', 'ros-jazzy-common-interfaces']
FE = ['scikit-fem>=10']
BAGS = ['rosbags>=0.10']
READERS = [*FE, 'h5py']
NASTRAN = [*READERS, 'pyNastran']  # asks for numpy below 2, so it is not in `all`
VIEW = ['matplotlib>=3.6', 'rich>=13']
TEST = ['pytest>=7', 'pytest-timeout', 'pytest-xdist', 'hypothesis', 'threadpoolctl', 'ruff',
        'mypy', 'types-PyYAML', 'pyuff', 'meshio']

setup(
    name=PACKAGE,
    version=VERSION,
    description='Online eigen-stability of disc brakes: squeal risk on ROS 2 topics',
    long_description=(HERE / 'README.md').read_text(encoding='utf-8'),
    long_description_content_type='text/markdown',
    license='Apache-2.0',
    maintainer='squeal_ros developers',
    maintainer_email='squeal-ros@example.org',
    python_requires='>=3.11',
    packages=find_packages(include=['squeal_core*', 'squeal_ros*']),
    package_data={'squeal_core': ['py.typed'], 'squeal_ros': ['py.typed']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (SHARE, ['package.xml']),
        (f'{SHARE}/launch', glob('launch/*.launch.py')),
        *((f'{SHARE}/{folder}', [f for f in glob(f'{folder}/*') if '.' in f.rpartition('/')[2]])
          for folder in CONFIG),
    ],
    zip_safe=True,
    install_requires=['setuptools', 'numpy>=1.26', 'scipy>=1.11', 'PyYAML'],
    extras_require={
        'ros': ROS, 'fe': FE, 'readers': READERS, 'nastran': NASTRAN, 'bags': BAGS, 'view': VIEW,
        'test': TEST,
        'colcon': ['colcon-common-extensions'],
        'demo': ROS + BAGS + VIEW,
        'all': ROS + READERS + BAGS + VIEW + TEST,
    },
    entry_points={'console_scripts': [
        'squeal = squeal_ros.start:squeal',
        'squeal_monitor = squeal_ros.start:monitor',
    ]},
)
