"""The command `reference attitude-error`: the table as printed, and with half of it."""

from dead_reckoning.tools.main import main

HEADER = (
    'angle_deg,acceleration,velocity_10s,position_10s,position_1min,position_10min,position_1h'
)


def test_table_is_as_printed(capsys):
    assert main(['reference', 'attitude-error']) == 0
    assert capsys.readouterr().out.splitlines() == [
        HEADER,
        '0.1,0.017,0.17,1.7,61.2,6120,220e3',
        '0.5,0.086,0.86,8.6,309.6,30960,1.1e6',
        '1.0,0.17,1.7,17,612,61200,2.2e6',
        '1.5,0.256,2.56,25.6,921.6,92160,3.3e6',
        '2.0,0.342,3.42,34.2,1231.2,123120,4.4e6',
        '3.0,0.513,5.13,51.3,1846.8,184680,6.6e6',
        '5.0,0.854,8.54,85.4,3074.4,307440,11e6',
    ]


def test_corrected_positions_are_half_of_that(capsys):
    assert main(['reference', 'attitude-error', '--corrected']) == 0
    assert capsys.readouterr().out.splitlines() == [
        HEADER,
        '0.1,0.017,0.17,0.85,30.6,3060,110e3',
        '0.5,0.086,0.86,4.3,154.8,15480,560e3',
        '1.0,0.17,1.7,8.5,306,30600,1.1e6',
        '1.5,0.256,2.56,12.8,460.8,46080,1.7e6',
        '2.0,0.342,3.42,17.1,615.6,61560,2.2e6',
        '3.0,0.513,5.13,25.65,923.4,92340,3.3e6',
        '5.0,0.854,8.54,42.7,1537.2,153720,5.5e6',
    ]
