"""The wire without ROS; what rclpy writes and reads is compared with in `nodes/test_wire.py`."""

import pytest

from dead_reckoning import wire
from dead_reckoning.core.errors import EncodingError, WireError
from dead_reckoning.core.samples import ImuSample

IMU = wire.encode_imu(ImuSample(5, 'imu_link', (1.0, 2.0, 3.0)))
DECODERS = (
    wire.decode_imu,
    wire.decode_acceleration,
    wire.decode_odometry,
    wire.decode_uint32,
    wire.decode_float64,
)


@pytest.mark.parametrize('decode', DECODERS)
@pytest.mark.parametrize('encapsulation', ['', '00', '0000', '00000000', '00020000', '01010000'])
def test_another_encoding_is_told_from_a_broken_message(decode, encapsulation):
    with pytest.raises(EncodingError, match='no little-endian CDR'):
        decode(bytes.fromhex(encapsulation) + (IMU[4:] if len(encapsulation) == 8 else b''))


@pytest.mark.parametrize('decode', DECODERS)
def test_a_broken_message_is_no_other_encoding(decode):
    with pytest.raises(WireError) as caught:
        decode(IMU[:4])
    assert type(caught.value) is WireError


def test_an_imu_is_laid_out_as_the_encoding_says():
    assert IMU[:4] == b'\0\1\0\0'
    assert IMU[4:16] == b'\0\0\0\0\5\0\0\0\x09\0\0\0'
    assert IMU[16:25] == b'imu_link\0'
    assert len(IMU) == 4 + 24 + 37 * 8
