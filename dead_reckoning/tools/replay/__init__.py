"""The command ``replay``: the chain over recordings, faster than real time."""
