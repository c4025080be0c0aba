# SPDX-License-Identifier: Apache-2.0
"""Reads 8-bit PNG files with nothing but the standard library: an independent look at what was written."""
import struct
import zlib
from pathlib import Path


def read_png(path):
    """(width, height, rows of (r, g, b) tuples)"""
    data = Path(path).read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n", f"{path} is no PNG"
    at, packed, ended = 8, b"", False
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + length]
        assert zlib.crc32(kind + body) == struct.unpack_from(">I", data, at + 8 + length)[0], "checksum"
        if kind == b"IHDR":
            width, height, depth, color, _, _, interlace = struct.unpack(">IIBBBBB", body)
            assert depth == 8 and color in (2, 6) and interlace == 0, (depth, color, interlace)
        elif kind == b"IDAT":
            packed += body
        ended = ended or kind == b"IEND"
        at += 12 + length
    assert ended, "IEND is missing"
    size = 3 if color == 2 else 4
    lines, raw = zlib.decompress(packed), []
    before = bytearray(width * size)
    for y in range(height):
        start = y * (width * size + 1)
        kind, line = lines[start], bytearray(lines[start + 1:start + 1 + width * size])
        for i in range(len(line)):
            left, up = line[i - size] if i >= size else 0, before[i]
            corner = before[i - size] if i >= size else 0
            if kind == 1:
                guess = left
            elif kind == 2:
                guess = up
            elif kind == 3:
                guess = (left + up) // 2
            elif kind == 4:
                nearest = left + up - corner
                guess = min((left, up, corner), key=lambda value: abs(nearest - value))
            else:
                guess = 0
            line[i] = (line[i] + guess) & 255
        raw.append([tuple(line[i:i + 3]) for i in range(0, len(line), size)])
        before = line
    return width, height, raw


def linear(shown):
    """The transfer function of sRGB: what a monitor shows, as linear light."""
    return shown / 12.92 if shown <= 0.04045 else ((shown + 0.055) / 1.055) ** 2.4


def monitor(light):
    """Its inverse."""
    return 12.92 * light if light <= 0.0031308 else 1.055 * light ** (1 / 2.4) - 0.055
