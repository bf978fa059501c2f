"""Boards on a serial port: bytes in, conversions out."""
