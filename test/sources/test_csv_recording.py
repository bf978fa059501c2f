"""Samples of a table; what is wrong with one is said with file, line, column and value."""

import math

import numpy as np
import pytest

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.blocks import ImuBlock, Stamped
from dead_reckoning.core.errors import InputError, OutOfRangeError
from dead_reckoning.core.samples import UNKNOWN
from dead_reckoning.sources.csv_recording import BLOCK, CsvRecording
from dead_reckoning.sources.driver import front_end, simulated_sensor

COUNTS = {'driver.samples_per_message': 4, 'driver.calibration_samples': 40}


@pytest.fixture
def table(tmp_path):
    def make(text, rate=None, **settings):
        path = tmp_path / 'table.csv'
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        return CsvRecording(path, Configuration(settings), rate)

    return make


def samples(recording):
    blocks = list(recording.blocks())
    return [block.sample(k) for block in blocks for k in range(len(block))]


def test_every_column_goes_where_it_belongs(table):
    (sample,) = samples(
        table(
            'stamp_ns,qx,qy,qz,qw,ax,ay,az,gx,gy,gz,label\n'
            '1700000000123456789,0.1,0.2,0.3,0.4,1,2,3e0,.5,-6.,+7,"a b"\n'
        )
    )
    assert sample.stamp_ns == 1_700_000_000_123_456_789
    assert sample.frame_id == 'imu_link'
    assert sample.specific_force == (1.0, 2.0, 3.0)
    assert sample.angular_velocity == (0.5, -6.0, 7.0)
    assert sample.orientation == (0.1, 0.2, 0.3, 0.4)
    assert sample.specific_force_covariance == sample.orientation_covariance == UNKNOWN


def test_what_there_is_no_column_for_is_not_measured(table):
    (sample,) = samples(table('stamp_ns,ax,ay,az\n5,1,2,3\n'))
    assert sample.orientation is None
    assert sample.angular_velocity is None


def test_four_zeros_are_no_orientation(table):
    first, second = samples(
        table('stamp_ns,ax,ay,az,qx,qy,qz,qw\n5,1,2,3,0,0,0,0\n6,1,2,3,0,0,0,1\n')
    )
    assert first.orientation is None
    assert second.orientation == (0.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ('time', 'stamp_ns'),
    [
        ('0.000000001', 1),
        ('0.1', 100_000_000),
        ('999999.999999999', 999_999_999_999_999),
        ('1700000000.123456789', 1_700_000_000_123_456_789),
        ('17e8', 1_700_000_000_000_000_000),
        ('-1.5', -1_500_000_000),
        ('0', 1),  # the stamp zero is none
    ],
)
def test_a_time_becomes_its_nanosecond(table, time, stamp_ns):
    (sample,) = samples(table(f'time,ax,ay,az\n{time},1,2,3\n'))
    assert sample.stamp_ns == stamp_ns


def test_without_stamps_the_rate_makes_them(table):
    read = samples(table('ax,ay,az\n' + '0,0,9.8\n' * 4, 3.0))
    assert [sample.stamp_ns for sample in read] == [
        333_333_333, 666_666_667, 1_000_000_000, 1_333_333_333
    ]  # fmt: skip


def test_a_rate_at_which_the_stamps_end_is_refused(table):
    with pytest.raises(InputError, match='--rate 1e-09'):
        table('ax,ay,az\n' + '0,0,9.8\n' * 4, 1e-9)


def test_nan_and_stamps_that_go_back_are_left_to_the_chain(table):
    first, second = samples(table('stamp_ns,ax,ay,az\n9,nan,-INF,0\n3,0,0,9.8\n'))
    assert math.isnan(first.specific_force[0])
    assert first.specific_force[1] == -math.inf
    assert (first.stamp_ns, second.stamp_ns) == (9, 3)


@pytest.mark.parametrize('end', ['\n', '\r\n', '', '\n\n\n'])
@pytest.mark.parametrize('mark', ['', '\ufeff'])
def test_ends_of_lines_and_byte_order_marks_do_not_matter(table, end, mark):
    text = f'{mark}"stamp_ns", ax ,ay,az{end or chr(10)}1, 0.5 ,0,9.8{end}'
    (sample,) = samples(table(text.replace('\n\n\n', '\n', 1)))
    assert sample.specific_force == (0.5, 0.0, 9.8)


def test_every_digit_is_kept_in_any_number_of_rows(table):
    generator = np.random.default_rng(1)
    force = generator.normal(size=(2 * BLOCK + 3, 3))
    rows = [f'{k + 1},{x!r},{y!r},{z!r}' for k, (x, y, z) in enumerate(force.tolist())]
    recording = table('\n'.join(['stamp_ns,ax,ay,az', *rows]))
    blocks = list(recording.blocks())
    assert len(recording) == len(force)
    assert [len(block) for block in blocks] == [BLOCK, BLOCK, 3]
    assert np.array_equal(np.concatenate([b.specific_force for b in blocks]), force)
    assert np.concatenate([b.stamp_ns for b in blocks]).tolist() == list(range(1, len(force) + 1))


def test_counts_go_through_the_front_end_of_the_driver(table):
    configuration = Configuration(COUNTS)
    conversions = simulated_sensor(configuration, 10**9).read(400)
    expected = front_end(configuration).add(conversions)
    rows = [
        f'{stamp},{x:.0f},{y:.0f},{z:.0f}'
        for stamp, (x, y, z) in zip(
            conversions.stamps_ns.tolist(), conversions.counts.tolist(), strict=True
        )
    ]
    read = samples(table('\n'.join(['stamp_ns,x,y,z', *rows]), **COUNTS))
    assert len(read) == len(expected) == 90
    for one, other in zip(read, expected, strict=True):
        assert (one.stamp_ns, one.specific_force) == (other.stamp_ns, other.specific_force)
        assert one.specific_force_covariance == other.specific_force_covariance


def test_counts_that_no_converter_gives_are_errors_of_their_own(table):
    text = 'x,y,z\n' + '2000,2000,2000\n' * 3 + 'nan,2000,2000\n2000,99999,2000\n'
    settings = {'driver.calibrate_on_start': False, 'driver.samples_per_message': 1}
    found = list(table(text, 100.0, **settings).blocks())
    errors = [value for value in found if isinstance(value, Stamped)]
    assert [type(error.value) for error in errors] == [OutOfRangeError] * 2
    assert [error.stamp_ns for error in errors] == [40_000_000, 50_000_000]
    assert '99999' in str(errors[1].value)
    assert sum(len(value) for value in found if isinstance(value, ImuBlock)) == 3


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('', "line 1: no header with the columns ax, ay, az or x, y, z, but ''"),
        ('1,2,3\n4,5,6', 'line 1: no header'),
        (b'\xff\xfe\x00', 'line 1: no header'),
        ('stamp_ns,ax,ay,az', 'no line after the header'),
        ('stamp_ns,ax,ay\n1,2,3', "line 1: no column az in 'stamp_ns,ax,ay'"),
        ('stamp_ns,x,y\n1,2,3', 'line 1: no column z'),
        ('stamp_ns,ax,ay,az,gx,gy\n1,2,3,4,5,6', 'line 1: no column gz'),
        ('stamp_ns,ax,ay,az,qw\n1,2,3,4,5', 'line 1: no column qx'),
        ('stamp_ns,ax,ay,az,ax\n1,2,3,4,5', 'line 1: more than one column ax'),
        ('time,ax,ay,az,time\n1,2,3,4,5', 'line 1: more than one column time'),
        ('stamp_ns,x,y,z,gx,gy,gz\n1,2,3,4,5,6,7', 'line 1: gx beside the counts'),
        ('ax,ay,az\n1,2,3', r'line 1: no column stamp_ns or time; give a --rate'),
        ('stamp_ns,ax,ay,az\n1,2,3,4\n5,6,seven,8', "line 3: ay is 'seven', which is no number"),
        ('stamp_ns,ax,ay,az\n1,2,3,0x1p3', "line 2: az is '0x1p3', which is no number"),
        ('stamp_ns,ax,ay,az\n1,2,3,1_0', "line 2: az is '1_0', which is no number"),
        ('stamp_ns,ax,ay,az\n1,2,3,4\n5,6, ,8', 'line 3: ay is empty'),
        ('stamp_ns,ax,ay,az\n1.5,2,3,4', "line 2: stamp_ns is '1.5', which is no whole number"),
        ('stamp_ns,ax,ay,az\nnan,2,3,4', "line 2: stamp_ns is 'nan', which is no whole number"),
        (
            'stamp_ns,ax,ay,az\n9000000000000000000,2,3,4',
            'line 2: stamp_ns is .* no time that a message',
        ),
        ('stamp_ns,ax,ay,az\n-9223372036854775808,2,3,4', 'line 2: stamp_ns is .* no time that'),
        ('stamp_ns,ax,ay,az\n99999999999999999999,2,3,4', 'line 2: stamp_ns is .* no whole'),
        ('time,ax,ay,az\n1,2,3,4\nnan,2,3,4', "line 3: time is 'nan', which is no time"),
        ('time,ax,ay,az\n3e9,2,3,4', "line 2: time is '3e9', which is no time"),
        ('stamp_ns,ax,ay,az\n1,2,3,4\n5,6,7', "line 3: '5,6,7' has 3 columns, not 4"),
        ('stamp_ns,ax,ay,az\n1,2,3,4,5', "line 2: '1,2,3,4,5' has 5 columns, not 4"),
        ('stamp_ns,ax,ay,az\n1,2,3,4\n\n5,6,7,8', "line 3: '' has 1 columns, not 4"),
        ('stamp_ns,ax,ay,az\n# a,2,3,4\n', "line 2: stamp_ns is '# a'"),
    ],
)
def test_what_can_not_be_read_is_named(table, text, words):
    with pytest.raises(InputError, match=rf'table\.csv.*{words}'):
        table(text)


def test_a_missing_table_is_named(tmp_path):
    with pytest.raises(InputError, match=r'nowhere\.csv: No such file'):
        CsvRecording(tmp_path / 'nowhere.csv', Configuration())
