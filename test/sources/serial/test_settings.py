"""Settings of a port, and of the driver that reads it."""

import pytest

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.pipeline import PipelineSettings
from dead_reckoning.sources.driver import serial_receiver
from dead_reckoning.sources.driver_settings import DriverSettings
from dead_reckoning.sources.serial.protocols.ascii import AsciiDecoder
from dead_reckoning.sources.serial.settings import SerialSettings


def test_a_byte_takes_ten_bits():
    assert SerialSettings(baud=9600).byte_time == pytest.approx(1.0416667e-3)


@pytest.mark.parametrize('port', ['', '  ', '/dev/\0tty'])
def test_a_port_that_can_be_none_is_refused(port):
    with pytest.raises(SettingsError, match=r'driver\.serial\.port') as caught:
        SerialSettings(port=port)
    assert repr(port) in str(caught.value)


def test_volts_of_a_digital_sensor_are_refused():
    parts = Configuration({'driver.sensor': 'adxl345', 'driver.serial.ascii.unit': 'volts'})
    with pytest.raises(SettingsError, match=r'driver\.serial\.ascii\.unit.*adxl345'):
        serial_receiver(parts)


def test_counts_of_another_converter_than_the_protocol_has_are_refused(monkeypatch):
    monkeypatch.setattr(AsciiDecoder, 'BITS', 10)
    with pytest.raises(SettingsError, match=r"driver\.adc_bits: 12 .*'ascii' has 10"):
        serial_receiver(Configuration())
    serial_receiver(Configuration({'driver.adc_bits': 10}))
    serial_receiver(Configuration({'driver.serial.ascii.unit': 'g'}))
    serial_receiver(Configuration({'driver.sensor': 'adxl345'}))


def test_a_board_is_neither_averaged_nor_calibrated_unasked():
    driver = DriverSettings(source='serial')
    assert driver.samples_per_message == 1
    assert not driver.calibrate_on_start
    assert DriverSettings().samples_per_message == 64
    assert DriverSettings(source='serial', samples_per_message=4).samples_per_message == 4


@pytest.mark.parametrize('source', ['simulated', 'serial'])
def test_the_source_of_the_pipeline_is_that_of_its_driver(source):
    others = {'simulated': 'serial', 'serial': 'simulated'}
    parts = Configuration({'pipeline.source': source, 'driver.source': others[source]})
    assert parts[DriverSettings].source == source
    assert parts[DriverSettings].calibrate_on_start == (source == 'simulated')


def test_without_a_source_of_its_own_the_pipeline_leaves_the_drivers_alone():
    parts = Configuration({'pipeline.source': 'topic', 'driver.source': 'serial'})
    assert parts[DriverSettings].source == 'serial'
    with pytest.raises(SettingsError, match=r"pipeline\.source: 'sirial'"):
        Configuration({'pipeline.source': 'sirial'})


def test_the_pipeline_has_all_sources_of_the_driver_and_a_topic():
    choices = {
        part: next(p.choices for p in part.parameters() if p.name == 'source')
        for part in (PipelineSettings, DriverSettings)
    }
    assert choices[PipelineSettings] == ('topic', *choices[DriverSettings])
