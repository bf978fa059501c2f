"""Small recordings from the simulator, and what the chain makes of them sample by sample."""

from dataclasses import replace
from functools import cache

from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from dead_reckoning import wire
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.compass import Compass, CompassSettings
from dead_reckoning.core.errors import SampleError
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.samples import ImuSample
from dead_reckoning.core.stages import COMPASS, RAW
from dead_reckoning.sources.driver import front_end, simulated_sensor
from dead_reckoning.sources.driver_settings import DriverSettings

START_NS = 1_700_000_000_000_000_000
IMU = 'sensor_msgs/msg/Imu'
STEPS = 8
WALKING = {
    'driver.motion': 'walk',
    'driver.range_g': 4.0,
    'driver.walk.steps': STEPS,
    'driver.walk.start': 1.0,
    'pipeline.estimators': ('integrator', 'pedometer'),
}
SECONDS = 8.0


@cache
def walk(seed=1):
    """Return a rest and a walk, as the driver gives them."""
    configuration = Configuration({**WALKING, 'driver.simulated.seed': seed})
    source = simulated_sensor(configuration, START_NS)
    count = round(SECONDS * configuration[DriverSettings].sample_rate)
    return tuple(front_end(configuration).add(source.read(count)))


def headings(samples, every=5):
    """Return a compass sample beside every few samples, in one sequence with them."""
    compass = Compass(CompassSettings(), 'compass_link')
    for number, sample in enumerate(samples):
        yield RAW, sample
        if number % every == 0:
            yield COMPASS, compass.sample(sample.stamp_ns + 1, 1.0 + 0.001 * number)


def spoiled(samples):
    """Return samples among which some can't be used, and the errors they cause."""
    nan = float('nan')
    spoiled = list(samples)
    spoiled[300] = replace(spoiled[300], specific_force=(nan, 0.0, 9.8))
    spoiled[310] = replace(spoiled[310], stamp_ns=spoiled[308].stamp_ns)
    spoiled[320] = replace(spoiled[320], stamp_ns=spoiled[319].stamp_ns)
    spoiled[330] = replace(spoiled[330], stamp_ns=0)
    return spoiled


def streamed(flow, **settings):
    """Return all outputs of the streaming chain by name, with the samples behind each."""
    pipeline = Pipeline(Configuration(WALKING | settings))
    found = {}
    for name, sample in flow:
        for output, value in pipeline.chain.push(name, sample):
            found.setdefault(output, []).append((sample, value))
    return found


def dropped(outputs):
    """Count the errors that cost a sample by their class."""
    counts = {}
    for _, error in outputs.get('fault', ()):
        if isinstance(error, SampleError):
            counts[type(error).__name__] = counts.get(type(error).__name__, 0) + 1
    return counts


def write_bag(path, flow, kind='mcap', namespace='/'):
    """Write named samples as a recording whose times are not the stamps; return its path."""
    cdr = get_typestore(Stores.ROS2_JAZZY)
    if kind == 'ros1':
        path = path.with_suffix('.bag')
        store = get_typestore(Stores.ROS1_NOETIC)
        writer = Writer1(path)
    else:
        store = cdr
        writer = Writer2(path, version=9, storage_plugin=StoragePlugin[kind.upper()])
    with writer:
        connections = {}
        for number, (name, sample) in enumerate(flow):
            if name not in connections:
                connections[name] = writer.add_connection(
                    f'{namespace}{name}', IMU, typestore=store
                )
            data = sample if isinstance(sample, bytes) else wire.encode_imu(sample)
            if kind == 'ros1':
                data = cdr.cdr_to_ros1(data, IMU)
            writer.write(connections[name], 10**9 + number, data)
    return path


def write_table(path, samples):
    """Write samples as CSV with every digit."""
    lines = ['stamp_ns,ax,ay,az']
    lines += [','.join(map(repr, (s.stamp_ns, *s.specific_force))) for s in samples]
    path.write_text('\n'.join(lines) + '\n')
    return path


def without_covariance(samples):
    """Return samples as a table can tell them."""
    return [ImuSample(s.stamp_ns, 'imu_link', s.specific_force) for s in samples]
