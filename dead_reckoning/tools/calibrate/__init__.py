"""The command `calibrate`: find a parameter from recordings of something known."""
