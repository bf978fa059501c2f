"""Reports of simulated recordings, opened in a browser."""

import re
import time
from dataclasses import fields, replace

import numpy as np
import pytest
from browser import assert_self_contained, opened

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.block_stages import blockwise
from dead_reckoning.core.blocks import ImuBlock, Stamped
from dead_reckoning.core.chain import FAULT, Chain
from dead_reckoning.core.common import CommonSettings, FrameSettings
from dead_reckoning.core.errors import GapError, NotFiniteError
from dead_reckoning.core.gravity import GravityRemoval
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.integrator import Integrator
from dead_reckoning.core.pedometer import Pedometer, PedometerSettings
from dead_reckoning.core.stages import (
    ODOMETRY,
    RAW,
    gravity_stage,
    integrator_stage,
    pedometer_stage,
)
from dead_reckoning.core.step_odometry import StepOdometry
from dead_reckoning.sources.driver import front_end, simulated_sensor
from dead_reckoning.sources.driver_settings import DriverSettings
from dead_reckoning.tools.presets import values_of
from dead_reckoning.tools.report.contents import (
    Accelerations,
    Collector,
    Contents,
    Fault,
    Track,
    settings_of,
)
from dead_reckoning.tools.report.page import write_report

START_NS = 1_700_000_000_000_000_000

SLIDE = {'driver.motion': 'slide', 'driver.slide.start': 2.0, 'integrator.movement_end': 'each'}
WALK = {
    **values_of('an900'),
    'driver.walk.roll': 0.0,
    'pedometer.axes': ['x', 'y', 'z'],
    'pedometer.input': 'imu/data',
}


def imu(values, seconds):
    configuration = Configuration(values)
    conversions = round(seconds * configuration[DriverSettings].sample_rate)
    source = simulated_sensor(configuration, START_NS)
    return configuration, ImuBlock.of(front_end(configuration).add(source.read(conversions)))


def replayed(name, configuration, *blocks, on_foot=False):
    """Return what the batch chain makes of a recording."""
    common = configuration[CommonSettings]
    removal = GravityRemoval(configuration[GravitySettings], common, configuration[FrameSettings])
    stages = [gravity_stage(removal)]
    if on_foot:
        settings = configuration[PedometerSettings]
        pedometer = Pedometer(settings, configuration[settings.method_part])
        stages.append(pedometer_stage(pedometer, StepOdometry(settings, common)))
    else:
        stages.append(integrator_stage(Integrator(configuration[IntegratorSettings], common)))
    chain = Chain([blockwise(stage) for stage in stages])
    collector = Collector()
    takers = collector.takers()
    for block in blocks:
        for topic, value in chain.push(RAW, block):
            if topic in takers:
                takers[topic](value)
    return collector.contents(name, sum(map(len, blocks)), settings=settings_of(configuration))


@pytest.fixture(scope='module')
def slide():
    """A slide with three samples that can't be used and a gap, in two blocks."""
    configuration, block = imu(SLIDE, 5.0)
    force, stamp_ns = block.specific_force.copy(), block.stamp_ns.copy()
    force[200:203] = np.nan
    stamp_ns[400:] += 2_000_000_000
    spoilt = replace(block, specific_force=force, stamp_ns=stamp_ns)
    blocks = [spoilt.part(0, 150), spoilt.part(150, len(block))]
    return replayed('a <slide> & more', configuration, *blocks)


def written(path, contents):
    write_report(path, contents)
    return path.read_text(encoding='utf-8')


def test_blocks_become_one(slide):
    dropped = sum(len(fault.stamp_ns) for fault in slide.faults if fault.dropped)
    assert len(slide.odometry.stamp_ns) + dropped == slide.samples
    assert (np.diff(slide.odometry.stamp_ns) > 0).all()


def test_report_of_a_slide_in_a_browser(slide, tmp_path):
    path = tmp_path / 'report.html'
    page = written(path, slide)
    assert_self_contained(page)
    document, widths = opened(path)
    assert '<title>dead_reckoning: a &lt;slide&gt; &amp; more</title>' in document
    # The way, height, velocity, acceleration, uncertainty, what was dropped.
    assert len(widths) == 6
    assert min(widths) > 0


def test_report_says_what_was_dropped_and_with_which_settings(slide, tmp_path):
    page = written(tmp_path / 'report.html', slide)
    assert '<code>NotFiniteError</code></td><td>3 dropped</td>' in page
    assert '<code>GapError</code></td><td>1 ×</td>' in page
    assert 'raise integrator.max_gap' in page
    changed, others = page.split('<details>')
    assert '<code>integrator.movement_end</code></td><td>each</td><td>all</td>' in changed
    assert '<code>gravity.attitude</code>' in others
    assert 'levelled: gravity is' in page


def test_report_of_a_walk_in_a_browser(tmp_path):
    configuration, block = imu(WALK, 30.0)
    contents = replayed('walk', configuration, block, on_foot=True)
    steps = contents.steps
    assert len(steps.step) > 30
    assert steps.step.tolist() == list(range(1, len(steps.step) + 1))
    assert steps.distance[-1] == pytest.approx(steps.step_length.sum())
    path = tmp_path / 'report.html'
    page = written(path, contents)
    assert f'<dt>steps</dt><dd>{len(steps.step)}<small>' in page
    assert 'The way on foot' in page
    assert 'Velocity' not in page
    assert min(opened(path)[1]) > 0


def test_an_hour_is_written_in_seconds_and_small(tmp_path):
    count = 720_000
    random = np.random.default_rng(1)
    stamp_ns = START_NS + 5_000_000 * np.arange(count)
    noise = random.normal(0.0, 0.5, (count, 3))
    velocity = np.cumsum(noise, axis=0) * 0.01
    states = Track(
        stamp_ns,
        np.cumsum(velocity, axis=0) * 0.005,
        velocity,
        np.ones((count, 4)),
        random.random(count) < 0.5,
    )
    contents = Contents(
        name='hour',
        samples=count,
        odometry=states,
        acceleration=Accelerations(stamp_ns, noise),
        faults=[Fault('LateSampleError', 'late', True, stamp_ns[::10].tolist())],
    )
    path = tmp_path / 'report.html'
    begun = time.process_time()
    write_report(path, contents)
    assert time.process_time() - begun < 20.0
    assert path.stat().st_size < 3_000_000
    assert min(opened(path)[1]) > 0


def begin(columns, count):
    return type(columns)(**{f.name: getattr(columns, f.name)[:count] for f in fields(columns)})


@pytest.mark.parametrize('count', [0, 1, 2])
def test_hardly_anything_makes_a_page_too(slide, tmp_path, count):
    contents = Contents(
        name='short',
        samples=count,
        odometry=begin(slide.odometry, count),
        acceleration=begin(slide.acceleration, count),
        faults=[Fault('NotFiniteError', 'nothing but NaN', True, [0])],
    )
    page = written(tmp_path / 'report.html', contents)
    assert ('<h2>The way</h2>' in page) is (count > 0)
    assert '<td>1 dropped</td><td>stamp 0</td>' in page or count == 0


def test_restart_is_no_way(slide, tmp_path):
    """The stamps of a second run go back by an hour; the time of the pictures goes on."""
    first, second = slide.odometry, begin(slide.odometry, 300)
    both = Track(
        *(np.concatenate([getattr(first, f.name), getattr(second, f.name)]) for f in fields(first))
    )
    both.stamp_ns[-300:] -= 3_600_000_000_000
    contents = Contents(name='twice', samples=len(both.stamp_ns), odometry=both)
    page = written(tmp_path / 'report.html', contents)
    length = np.linalg.norm(np.diff(first.position, axis=0), axis=1).sum()
    length += np.linalg.norm(np.diff(second.position, axis=0), axis=1).sum()
    assert f'<dt>length of the way</dt><dd>{length:.3g} m' in page
    begun = float(re.search(r'<dt>duration</dt><dd>([0-9.]+) s', page).group(1))
    spans = [np.ptp(track.stamp_ns) / 1e9 for track in (first, second)]
    assert begun == pytest.approx(sum(spans), abs=0.05)


def test_where_nothing_takes_gravity_off_the_specific_force_is_shown(slide, tmp_path):
    states = slide.odometry
    count = len(states.stamp_ns)
    force = np.tile((0.0, 0.0, 9.8), (count + 1, 1))
    collector = Collector(RAW)
    takers = collector.takers()
    unused = np.zeros((count + 1, 9))
    stamp_ns = np.append(states.stamp_ns, 0)
    takers[RAW](ImuBlock(stamp_ns, 'imu_link', force, unused, force, unused, unused, unused))
    collector._add(ODOMETRY, tuple(getattr(states, f.name) for f in fields(states)))
    contents = collector.contents('foot', count + 1)
    assert contents.force.stamp_ns.tolist() == states.stamp_ns.tolist()
    page = written(tmp_path / 'report.html', contents)
    assert '<h2>Specific force</h2>' in page
    assert '<h2>Linear acceleration</h2>' not in page


def test_figures_have_no_exponents(slide, tmp_path):
    odometry = replace(
        slide.odometry, covariance=np.full_like(slide.odometry.covariance, 272.0**2)
    )
    page = written(tmp_path / 'report.html', Contents(name='far', samples=1, odometry=odometry))
    assert 'σ 272, 272, 272 m' in page


def test_a_page_is_written_the_same_again(slide, tmp_path):
    assert written(tmp_path / 'a.html', slide) == written(tmp_path / 'b.html', slide)


def test_findings_are_no_drops():
    collector = Collector()
    for error in (NotFiniteError('x'), GapError('y'), NotFiniteError('z')):
        collector.takers()[FAULT](Stamped(START_NS, error))
    first, second = collector.contents('faults', 3).faults
    assert (first.kind, first.words, first.dropped) == ('NotFiniteError', 'x', True)
    assert len(first.stamp_ns) == 2
    assert not second.dropped
