"""The documents' own programs, exact to the bit, to check a port to a controller against.

A module per document, in the document's units: counts, not SI.  The chain of this package does
not use them; ``docs/reference-algorithms.md`` says what it does instead.
"""
