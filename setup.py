"""Files beyond the packages, as ament_python installs them; the rest is in pyproject.toml."""

from glob import glob

from setuptools import setup

PACKAGE = 'squeal_ros'
SHARE = f'share/{PACKAGE}'
CONFIG = ('config', 'config/brakes', 'config/models', 'config/drive_cycles', 'config/vehicles',
          'config/layouts', 'config/security')

setup(
    python_requires='>=3.11',
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (SHARE, ['package.xml']),
        (f'{SHARE}/launch', glob('launch/*.launch.py')),
        *((f'{SHARE}/{folder}', [f for f in glob(f'{folder}/*') if '.' in f.rpartition('/')[2]])
          for folder in CONFIG),
    ],
)
