"""Build the package; colcon and pip both read this."""

from glob import glob

from setuptools import find_packages, setup

PACKAGE = 'dead_reckoning'
NODES = (
    'accelerometer_driver',
    'compass_driver',
    'gravity_removal',
    'inertial_navigator',
    'integrator',
    'pedometer',
    'pipeline',
)

setup(
    name=PACKAGE,
    version='0.1.0',
    description='Position and velocity from inertial sensors, on ROS 2',
    license='Apache-2.0',
    maintainer='dead_reckoning maintainers',
    maintainer_email='maintainers@users.noreply.h-seed-edd4a040.example',
    packages=find_packages(include=[PACKAGE, f'{PACKAGE}.*']),
    python_requires='>=3.10',
    # ROS itself is no pip requirement: it comes from the sourced installation.
    install_requires=[
        'filterpy',
        'matplotlib',
        'numba',
        'numpy',
        'orjson',
        'pyserial',
        'PyYAML',
        'rosbags',
        'scipy',
        'smbus2',
    ],
    extras_require={'cluster': ['distributed'], 'test': ['hypothesis', 'pytest']},
    zip_safe=True,
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
        (f'share/{PACKAGE}/config', sorted(glob('config/*.*'))),
        (f'share/{PACKAGE}/launch', sorted(glob('launch/*.launch.py'))),
        (f'share/{PACKAGE}/rviz', sorted(glob('rviz/*.rviz'))),
    ],
    entry_points={
        'console_scripts': [
            *(f'{node} = {PACKAGE}.nodes.executables:{node}' for node in NODES),
            f'dead-reckoning = {PACKAGE}.tools.main:main',
        ],
    },
)
