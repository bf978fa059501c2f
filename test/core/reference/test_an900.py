"""AN-900's listing, computed by hand where it is peculiar, and against a slow transcription."""

import math
import struct

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.reference import an900
from dead_reckoning.sources.driver import simulated_sensor
from dead_reckoning.tools.generate import PRESETS

FUDGE = float(np.float32(0.0249))


def single(value):
    """Round a double to a float of 32 bits, without numpy."""
    return struct.unpack('f', struct.pack('f', value))[0]


def singles(*values):
    return np.array(values, np.float32)


def transcription(counts, corrected, average):
    """Compute what the listing does, variable by variable, in doubles that are rounded each time.

    The sum, the product or the quotient of two floats of 32 bits, computed in doubles and then
    rounded, is that of 32 bits.
    """
    flag, high, low = 2, -10000.0, 10000.0
    newest_high, newest_low = -10000.0, 10000.0
    new = old = average_stride = distance = 0.0
    buffer, seen, steps, rows = [], 0, 0, []
    for x, y in counts:
        if seen > 7:
            old = new
            new = single(new - buffer[len(buffer) - 8])
        square = single((x - 8192) ** 2 + (y - 8192) ** 2)
        sample = single(math.sqrt(square / 16.0))
        buffer.append(sample)
        new = single(new + sample)
        change = single(new - old)
        if (abs(change) if corrected else abs(int(change))) < 1.0:
            new = old
        newest_high, newest_low = max(newest_high, sample), min(newest_low, sample)
        seen += 1
        if seen <= 8:
            continue
        up, down = new > single(old + 5.0), new < single(old - 5.0)
        step = False
        if flag == 2:
            flag = 1 if up else 0 if down else 2
        elif flag == 1:
            middle = single(single(high + low) / 2.0)
            bound = middle if corrected else single(high + single(low / 2.0))
            step = high > low and new > middle and old < bound
            if not step and down:
                flag, high = 0, max(high, old)
        elif up:
            flag, low = 1, min(low, old)
        if not step:
            continue
        inner = buffer[4 : len(buffer) - 4]
        mean = 0.0
        for value in inner:
            mean = single(mean + value)
        mean = single(mean / (len(buffer) - 8))
        velocity = displacement = 0.0
        for value in inner:
            velocity = single(velocity + single(value - mean))
            displacement = single(displacement + velocity)
        top = single(displacement * single(newest_high - newest_low))
        bottom = single(mean - newest_low)
        if bottom:
            ratio = single(top / bottom)
        else:
            ratio = math.copysign(math.inf, top) if top else math.nan
        if corrected:
            size = abs(ratio)
        else:
            size = 0 if math.isnan(ratio) else math.floor(min(abs(ratio), 2.0**31 - 1.0))
        stride = single(single(math.sqrt(size)) * single(0.0249))
        if steps < 2:
            average_stride = stride
        else:
            weighted = single(single(average - 1) * average_stride)
            average_stride = single(single(weighted + stride) / single(average))
        steps += 1
        distance = single(distance + average_stride)
        rows.append((seen - 1, stride, average_stride, steps, distance))
        buffer = buffer[-8:]
        newest_high, newest_low = -10000.0, 10000.0
        high, low = -10000.0, 10000.0
    return rows


def run(counts, **options):
    return [
        (step.sample, step.stride, step.average_stride, step.steps, step.distance)
        for step in an900.run(np.array(counts, np.int64).reshape(-1, 2), **options)
    ]


def along_x(magnitudes):
    """Return counts whose magnitudes are these: whole multiples of a quarter."""
    return [(an900.ZERO_G + round(4 * value), an900.ZERO_G) for value in magnitudes]


def walk(count=600, cadence=1.8, amplitude=120.0, level=410.0):
    turn = 2.0 * np.pi * cadence * np.arange(count) / 30.0
    return along_x(level - amplitude * np.cos(turn) + 0.3 * amplitude * np.cos(2.0 * turn))


# --- magnitudes -----------------------------------------------------------------------------


def test_zero_is_four_conversions_of_half_the_range():
    assert an900.ZERO_G == 8192
    assert an900.magnitudes(np.array([[8192, 8192]])) == [0.0]


def test_four_conversions_count_as_one():
    """√(1200² + 1600²) / 4."""
    assert an900.magnitudes(np.array([[9392, 6592], [6992, 9792]])).tolist() == [500.0, 500.0]


def test_squares_of_both_ends_of_the_range_fit():
    low, high = an900.magnitudes(np.array([[0, 0], [16380, 16380]])).tolist()
    assert low == single(2048.0 * math.sqrt(2.0))
    assert high == single(2047.0 * math.sqrt(2.0))


def test_sum_of_squares_is_rounded_before_its_root():
    """4099² + 2² = 16801805 is 16801804 in 24 bits, where only even numbers are left."""
    square = np.float32(4099**2 + 2**2)
    assert int(square) == 16801804
    (magnitude,) = an900.magnitudes(np.array([[8192 + 4099, 8192 + 2]]))
    assert magnitude == single(math.sqrt(16801804 / 16.0))


def test_root_of_floats_gives_the_same_as_the_listings_root_of_doubles():
    counts = np.random.default_rng(1).integers(0, 16381, (20000, 2))
    square = ((counts - 8192) ** 2).sum(axis=1).astype(np.float32)
    np.testing.assert_array_equal(
        an900.magnitudes(counts), np.sqrt(square / np.float32(16.0), dtype=np.float32)
    )


# --- moving sum -----------------------------------------------------------------------------


def test_first_eight_add_up():
    sums = an900.moving_sums(singles(*range(2, 12)))
    assert sums.tolist() == [2, 5, 9, 14, 20, 27, 35, 44, 52, 60]


def test_sum_below_one_is_put_back_to_nothing_at_the_beginning():
    """Until the ninth sample the change is taken from 0, not from the sum before."""
    sums = an900.moving_sums(singles(0.5, 0.25, 0.5, 0.5, 3.0))
    assert sums.tolist() == [0.0, 0.0, 0.0, 0.0, 3.0]


def test_what_is_put_back_stays_for_good():
    """From 100 to 100.5: the sum should be 804, and never is; a jump comes on top of 800."""
    samples = [100.0] * 8 + [100.5] * 40 + [110.5] * 8
    sums = an900.moving_sums(singles(*samples)).tolist()
    assert sums[7:48] == [800.0] * 41
    assert sums[48:] == [810.0, 820.0, 830.0, 840.0, 850.0, 860.0, 870.0, 880.0]
    assert sum(samples[-8:]) == 884.0


@pytest.mark.parametrize(
    ('change', 'taken'), [(0.75, 0.0), (1.0, 1.0), (-0.75, 0.0), (-1.0, -1.0)]
)
def test_change_of_one_is_taken(change, taken):
    """The integer `abs` of the listing is 0 below 1, as the float is below it."""
    sums = an900.moving_sums(singles(*[100.0] * 8, 100.0 + change))
    assert sums[-1] == 800.0 + taken


def test_sum_is_rounded_as_it_is_carried_on():
    """2¹² + 1 − 2⁻¹² needs 25 bits and becomes 4097; without 4096 then, 1 is left of 0.9998."""
    small = 1.0 - 2.0**-12
    sums = an900.moving_sums(singles(4096.0, small, *[0.0] * 7)).tolist()
    assert sums[0] == 4096.0
    assert sums[7] == 4097.0
    assert sums[8] == 1.0


# --- steps ----------------------------------------------------------------------------------


def found(*sums, corrected=False):
    """Return at which of these sums a step is; the first is the one before the first look."""
    padded = singles(*[0.0] * 7, *sums)
    return [at - 7 for at in an900.crossings(padded, corrected)]


def test_step_is_where_the_sum_rises_through_the_middle():
    """Maximum 110, minimum 80, middle 95."""
    sums = (100, 110, 104, 80, 90, 94, 96, 120)
    assert found(*sums) == found(*sums, corrected=True) == [6]


def test_middle_itself_is_not_above_it():
    sums = (100, 110, 104, 80, 90, 95, 96)
    assert found(*sums) == [6]
    assert found(*sums, corrected=True) == []


def test_parenthesis_lets_a_rise_count_that_began_above_the_middle():
    """80 to 120 in one sample only turns the slope; 110 + 80/2 = 150 lets the next one count."""
    sums = (100, 110, 104, 80, 120, 130)
    assert found(*sums) == [5]
    assert found(*sums, corrected=True) == []


def test_parenthesis_loses_the_step_beyond_maximum_and_half_the_minimum():
    sums = (100, 110, 104, 80, 150, 160)
    assert found(*sums) == []
    assert found(100, 110, 104, 80, 149, 160) == [5]


def test_parenthesis_loses_steps_of_negative_sums():
    """The dead band can leave sums below zero: −10 + (−40)/2 is below the middle, −25."""
    sums = (-20, -10, -16, -40, -34, -28, -22, -18)
    assert found(*sums) == []
    assert found(*sums, corrected=True) == [6]


def test_slope_is_more_than_five():
    assert found(100, 110, 104, 80, 90, 94, 96) == [6]
    assert found(100, 110, 105, 80, 90, 94, 96) == [5]
    assert found(100, 105, 99, 80, 90, 94, 96) == []


def test_first_rise_has_no_maximum_and_is_no_step():
    assert found(100, 80, 90, 120, 160) == []


def test_after_a_step_both_extremes_are_new():
    sums = (100, 110, 104, 80, 90, 94, 96, 90, 60, 70, 77, 79, 90)
    assert found(*sums) == [6, 11]


def test_step_takes_three_samples_at_least():
    """Turn down, turn up, cross."""
    assert found(100, 110, 104, 80, 90, 96, 90, 97, 98) == [5, 8]


def test_maximum_stays_until_the_next_step():
    """A jolt to 1000 puts the middle out of reach: (1000 + 80) / 2."""
    beat = (110, 104, 80, 90, 94, 96)
    assert found(100, *beat, *beat) == [6, 12]
    assert found(100, 1000, *beat, *beat, *beat) == []


def test_minimum_starts_at_ten_thousand():
    """Of sums above it there is no minimum: the middle of 12110 and 10000 is 11055."""
    sums = (12100, 12110, 12104, 12080, 12090, 12091, 12096)
    assert found(*sums) == [5]
    assert found(*sums, corrected=True) == []
    low = tuple(value - 4000 for value in sums)
    assert found(*low) == found(*low, corrected=True) == [6]


def test_eight_samples_are_never_looked_at():
    for count in range(9):
        assert run(walk()[:count]) == []
    assert an900.crossings(singles()) == []


# --- stride ---------------------------------------------------------------------------------


def stride(samples, carried=0, corrected=False):
    """Return the stride of a step of these samples, the first of which are of the one before."""
    before = [9.0] * 5
    if not carried:
        return float(an900.strides(singles(*samples), [len(samples) - 1], corrected)[-1])
    found = [len(before) + carried - 1, len(before) + len(samples) - 1]
    return float(an900.strides(singles(*before, *samples), found, corrected)[-1])


def test_stride_by_hand():
    """Mean 2 of 4, 0, 2; velocities 2, 0, 0; their sum 2; 2 · 8 / 2 = 8."""
    samples = [0, 0, 0, 0, 4, 0, 2, 0, 0, 0, 8]
    assert stride(samples) == stride(samples, corrected=True) == single(single(8**0.5) * FUDGE)


def test_integer_abs_cuts_off_under_the_root():
    """2 · 7.5 / 2 = 7.5 is 7."""
    samples = [0, 0, 0, 0, 4, 0, 2, 0, 0, 0, 7.5]
    assert stride(samples) == single(single(7**0.5) * FUDGE)
    assert stride(samples, corrected=True) == single(single(7.5**0.5) * FUDGE)


def test_less_than_one_under_the_root_is_no_length_at_all():
    samples = [0, 0, 0, 0, 4, 0, 2, 0, 0, 0, 0.75]
    assert stride([*samples[:4], 0.5, 0, 0.25, *[0] * 3, 0.75]) == 0.0
    assert stride([*samples[:4], 0.5, 0, 0.25, *[0] * 3, 0.75], corrected=True) > 0.0


def test_mean_is_of_other_samples_than_the_extremes():
    """Mean 2 of 1, 3, 2, carried over; extremes 9 and 5: −1 · 4 / (2 − 5) = 4/3."""
    samples = [7, 7, 7, 7, 1, 3, 2, 7, 5, 9, 6]
    assert stride(samples, carried=8) == single(FUDGE)
    corrected = single(single(math.sqrt(single(4 / 3))) * FUDGE)
    assert stride(samples, carried=8, corrected=True) == corrected


def test_negative_is_taken_absolute():
    """Velocities −2, 0, 0; −2 · 8 / 2 = −8."""
    samples = [0, 0, 0, 0, 0, 4, 2, 0, 0, 0, 8]
    assert stride(samples) == single(single(8**0.5) * FUDGE)


def test_nothing_by_zero_is_zero_and_corrected_no_number():
    samples = [3, 3, 3, 3, 3, 3, 3, 5, 4, 9, 6]
    assert stride(samples) == 0.0
    assert math.isnan(stride(samples, corrected=True))


def test_something_by_zero_is_the_greatest_integer_and_corrected_infinite():
    samples = [7, 7, 7, 7, 3, 1, 5, 7, 3, 7, 6]
    assert stride(samples, carried=8) == single(single(math.sqrt(2**31 - 1)) * FUDGE)
    assert stride(samples, carried=8, corrected=True) == math.inf


# --- average and distance -------------------------------------------------------------------


def test_first_two_strides_stand_for_themselves_and_the_rest_is_averaged():
    steps = run(walk(), average=4)
    strides = [step[1] for step in steps]
    assert strides == [step[1] for step in run(walk())]
    average = strides[1]
    assert [step[2] for step in steps[:2]] == strides[:2]
    for step in steps[2:]:
        average = single(single(3.0 * average + 0.0) + step[1])
        average = single(average / 4.0)
        assert step[2] == average


def test_distance_adds_the_averages_in_floats():
    distance = 0.0
    steps = run(walk(3000), average=3)
    assert [step[3] for step in steps] == list(range(1, len(steps) + 1))
    for step in steps:
        distance = single(distance + step[2])
        assert step[4] == distance
    assert distance != sum(step[2] for step in steps)


def test_average_of_one_is_the_stride():
    assert all(step[1] == step[2] for step in run(walk()))


# --- whole walks ----------------------------------------------------------------------------


@pytest.mark.parametrize('cadence', [0.8, 1.25, 1.75, 2.25, 2.5])
def test_simulated_walk_of_sixty_steps_has_fifty_nine(cadence):
    """Through a simulated ADXL330; a ripple counts where the parenthesis lets it."""
    values = next(preset for preset in PRESETS if preset.name == 'an900').values
    configuration = Configuration(
        {**values, 'driver.walk.cadence': cadence, 'driver.walk.steps': 60}
    )
    source = simulated_sensor(configuration, 10**18)
    conversions = source.read(round((60 / cadence + 6.0) * 120)).counts
    sums = conversions[: len(conversions) // 4 * 4, :2].reshape(-1, 4, 2).sum(axis=1)
    counts = sums.astype(np.int64)
    assert len(an900.run(counts)) in (59, 60)
    assert len(an900.run(counts, corrected=True)) == 59


def test_walk_is_counted_and_its_first_step_is_lost():
    assert len(run(walk(600, cadence=1.5))) == 29


@pytest.mark.parametrize('corrected', [False, True])
@pytest.mark.parametrize('pause', [42, 43, 51, 3000])
def test_pause_overruns_nothing(pause, corrected):
    """The listing's 50 floats hold 8 and 42; here the step that ends the pause has them all."""
    counts = walk(300) + along_x([410.0] * pause) + walk(300)
    steps = run(counts, corrected=corrected)
    assert steps == transcription(counts, corrected, 1)
    assert len(steps) > 2 * len(run(walk(300), corrected=corrected)) - 2


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize('average', [1, 3])
def test_division_by_zero_spoils_the_distance_only_if_corrected(average):
    """The mean of a step is its minimum: all that it is taken of is 100."""
    odd = [100.0, 200.0, 100.0, 100.0, 100.0, 100.0, 100.0, 100.0, 200.0, 100.0, 140.0, 120.0]
    counts = along_x(odd) + walk()
    printed, corrected = (run(counts, corrected=flag, average=average) for flag in (False, True))
    assert printed[0][:3] == (11, 0.0, 0.0)
    assert all(math.isfinite(step[4]) for step in printed)
    assert corrected[0][0] == 11
    assert math.isnan(corrected[0][1])
    assert all(math.isfinite(step[1]) and math.isfinite(step[2]) for step in corrected[1:])
    assert all(math.isnan(step[4]) for step in corrected)


def test_steps_of_one_sharp_sample_are_lost_where_the_parenthesis_is_repaired():
    """The sum rises past the middle in the very sample that turns the slope."""
    counts = along_x([1000.0 if n % 16 == 10 else 410.0 for n in range(480)])
    assert len(run(counts)) == 29
    assert run(counts, corrected=True) == []


def shaped(seed, shape, count):
    """Return counts of a shape: noise, a walk, rests with jolts, few values, a slow drift."""
    random = np.random.default_rng(seed)
    if shape == 'noise':
        counts = random.integers(0, 16381, (count, 2))
    elif shape == 'quiet':
        counts = 8192 + random.integers(-4, 5, (count, 2))
    elif shape == 'walk':
        turn = random.uniform(0.1, 1.0) * np.arange(count)
        counts = 8192 + random.normal(0.0, 30.0, (count, 2))
        counts[:, 0] += 1638.0 + random.uniform(10.0, 2000.0) * np.sin(turn)
    elif shape == 'jolts':
        counts = np.full((count, 2), 8192 + random.integers(0, 2000))
        counts[random.random(count) < 0.1] = random.integers(0, 16381, 2)
    elif shape == 'few':
        counts = 8192 + random.choice([0, 1, 30, 8188, -8192], (count, 2))
    else:
        counts = 8192 + np.cumsum(random.integers(-60, 61, (count, 2)), axis=0)
    return np.clip(np.round(counts), 0, 16380).astype(np.int64).tolist()


@given(
    st.integers(0, 2**32),
    st.sampled_from(['noise', 'quiet', 'walk', 'jolts', 'few', 'drift']),
    st.integers(9, 500),
    st.booleans(),
    st.sampled_from([1, 2, 5, 16777219]),
)
@example(1, 'walk', 2000, False, 1)
@example(1, 'noise', 3000, True, 3)
@example(2, 'few', 3000, False, 1)
def test_equals_the_slow_transcription(seed, shape, count, corrected, average):
    counts = shaped(seed, shape, count)
    expected = transcription(counts, corrected, average)
    # As text, since NaN equals nothing.
    assert repr(run(counts, corrected=corrected, average=average)) == repr(expected)


@given(
    st.lists(st.tuples(st.integers(0, 16380), st.integers(0, 16380)), min_size=9, max_size=120),
    st.booleans(),
)
def test_any_counts_equal_the_slow_transcription(counts, corrected):
    assert repr(run(counts, corrected=corrected)) == repr(transcription(counts, corrected, 1))
