"""What the benchmark of decoders feeds: readings of every board, and questions before noise."""

import numpy as np
import pytest

from benchmarks.decoders import PIECE, fed, good_pieces, random_pieces
from dead_reckoning.sources.serial import protocols


def decoder(name):
    kind = protocols.decoder_class(name)
    return kind(kind.Settings())


@pytest.mark.parametrize('name', protocols.names())
def test_good_bytes_are_mostly_readings(name):
    """Of the longest there are, the two packets of a UM7 and lines of text, some 74 bytes each."""
    made = decoder(name)
    size, found, spent = fed(made, good_pieces(name, made, 20_000))
    assert size >= 20_000
    assert found > size / 80
    assert spent > 0.0


def test_a_decoder_that_polls_has_asked_for_its_random_bytes():
    made = decoder('zstar')
    size, _, _ = fed(made, random_pieces(made, 3 * PIECE))
    assert size == 3 * PIECE
    assert made.due(np.inf) == b'R'
    assert len(made.feed(b'N')) == 1  # says that what came last was no answer
