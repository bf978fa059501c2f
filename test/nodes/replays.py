"""What `replay` makes of messages that a node got over DDS."""

import yaml
from rosbags.rosbag2 import Reader

from dead_reckoning.sources.bags import BagWriter
from dead_reckoning.tools.main import main


def odometry_of(topic, messages, settings, folder):
    """Record Imu messages in a bag, replay it, and return the messages of its `odom`, as bytes."""
    writer = BagWriter(folder / 'recorded', {f'/{topic}': ('sensor_msgs/msg/Imu', False)})
    for number, message in enumerate(messages):
        writer.write(f'/{topic}', number, message)
    writer.close()
    config = folder / 'config.yaml'
    config.write_text(yaml.safe_dump({'/**': {'ros__parameters': settings}}))
    output = ['--config', str(config), '--output', str(folder / 'out'), '--outputs', 'bag']
    assert main(['replay', str(folder / 'recorded'), *output]) == 0
    with Reader(folder / 'out/bag') as reader:
        odometry = [c for c in reader.connections if c.topic == '/odom']
        return [data for _, _, data in reader.messages(odometry)]
