"""What `replay` makes of messages that a node got over DDS."""

import yaml
from rosbags.rosbag2 import Reader

from dead_reckoning.core.common import FrameSettings
from dead_reckoning.sources.bags import BagWriter
from dead_reckoning.tools.main import main
from dead_reckoning.topics import topics


def odometry_of(topic, messages, settings, folder):
    """Record Imu messages in a bag, replay it, and return the messages of its `odom`, as bytes."""
    return odometry_of_all([(topic, message) for message in messages], settings, folder)


def odometry_of_all(messages, settings, folder):
    """Do so with messages of any topics, in their order."""
    known = topics(FrameSettings())
    types = {f'/{name}': (known[name].type, False) for name, _ in messages}
    writer = BagWriter(folder / 'recorded', types)
    for number, (name, message) in enumerate(messages):
        writer.write(f'/{name}', number, message)
    writer.close()
    config = folder / 'config.yaml'
    config.write_text(yaml.safe_dump({'/**': {'ros__parameters': settings}}))
    output = ['--config', str(config), '--output', str(folder / 'out'), '--outputs', 'bag']
    assert main(['replay', str(folder / 'recorded'), *output]) == 0
    with Reader(folder / 'out/bag') as reader:
        odometry = [c for c in reader.connections if c.topic == '/odom']
        return [data for _, _, data in reader.messages(odometry)]
