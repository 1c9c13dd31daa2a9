"""Contrasts and distances of colours, for eyes of any kind."""

import math

from warehouse_core.render.palette import Color


def linear(color: Color) -> Color:
    """Return the light of each part of an sRGB colour."""
    red, green, blue = (
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in color
    )
    return red, green, blue


def contrast(one: Color, other: Color) -> float:
    """Return the contrast of two colours, 1 to 21, by WCAG 2."""

    def luminance(color: Color) -> float:
        red, green, blue = linear(color)
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue

    darker, lighter = sorted((luminance(one), luminance(other)))
    return (lighter + 0.05) / (darker + 0.05)


IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

EYES = {
    "normal": IDENTITY,
    "protanopia": (
        (0.152286, 1.052583, -0.204868),
        (0.114503, 0.786281, 0.099216),
        (-0.003882, -0.048116, 1.051998),
    ),
    "deuteranopia": (
        (0.367322, 0.860646, -0.227968),
        (0.280085, 0.672501, 0.047413),
        (-0.011820, 0.042940, 0.968881),
    ),
    "tritanopia": (
        (1.255528, -0.076749, -0.178779),
        (-0.078411, 0.930809, 0.147602),
        (0.004733, 0.691367, 0.303900),
    ),
}
"""Linear RGB as other eyes see it. Source: Machado, Oliveira and Fernandes, A Physiologically-based
Model for Simulation of Color Vision Deficiency, IEEE TVCG 15(6), 2009, severity 1.0."""


def seen_by(eyes: str, color: Color) -> Color:
    """Return a colour as other eyes see it."""
    parts = linear(color)
    mixed = [
        min(1.0, max(0.0, sum(share * part for share, part in zip(row, parts, strict=True))))
        for row in EYES[eyes]
    ]
    red, green, blue = (
        12.92 * c if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055 for c in mixed
    )
    return red, green, blue


def seen_contrast(eyes: str, one: Color, other: Color) -> float:
    """Return the contrast of two colours as other eyes see them."""
    return contrast(seen_by(eyes, one), seen_by(eyes, other))


XYZ = ((0.4124564, 0.3575761, 0.1804375), (0.2126729, 0.7151522, 0.0721750),
       (0.0193339, 0.1191920, 0.9503041))  # fmt: skip
WHITE = (0.95047, 1.0, 1.08883)
"""Linear sRGB as CIE XYZ, and white of daylight (D65). Source: IEC 61966-2-1."""


def lab(color: Color) -> Color:
    """Return a colour in CIE L*a*b*."""
    parts = linear(color)
    x, y, z = (
        sum(share * part for share, part in zip(row, parts, strict=True)) / white
        for row, white in zip(XYZ, WHITE, strict=True)
    )
    a, b, c = (t ** (1 / 3) if t > 216 / 24389 else (24389 / 27 * t + 16) / 116 for t in (x, y, z))
    return 116 * b - 16, 500 * (a - b), 200 * (b - c)


def seen_distance(eyes: str, one: Color, other: Color) -> float:
    """Return the distance of two colours as other eyes see them (CIE 1976)."""
    return math.dist(lab(seen_by(eyes, one)), lab(seen_by(eyes, other)))
