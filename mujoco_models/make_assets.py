"""Draw the vehicles: write the meshes and the palette that the MJCF files of this folder show.

Run it after a change of shape (`python mujoco_models/make_assets.py`) and commit what it writes.
Each airframe is two meshes: `<name>_body.obj`, whose colors come from one cell of `palette.png` per face, and
`<name>_accent.obj` (front propellers and top plate), which takes the color of its drone.
Two meshes and not thirty primitives, because every geom costs the physics 0.03 us per drone and step.

Lengths in m, x forward, y left, z up, origin at the center of mass (docs/reference/vehicle.md#1).
"""

import itertools
import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

ASSETS = Path(__file__).resolve().parent / "assets"

PALETTE = {
    "board": (30, 33, 38),
    "plastic": (52, 55, 60),
    "metal": (176, 181, 188),
    "battery": (128, 138, 150),
    "blade": (38, 40, 45),
    "pin": (212, 176, 92),
    "led_front": (70, 255, 120),
    "led_back": (70, 130, 255),
    "leg": (222, 224, 226),
    "chip": (66, 70, 76),
    "wire": (196, 40, 36),
    "guard": (70, 74, 80),
}
"""Name to sRGB color (0-255); the order is the order of the cells in the image."""

CELL = 8  # pixels per side of a palette cell


@dataclass
class Part:
    """Triangles of one color."""

    color: str
    corners: NDArray[np.float64]  # (T, 3, 3), counter-clockwise seen from outside
    normals: NDArray[np.float64]  # (T, 3, 3), one per corner

    def moved(self, offset: ArrayLike, yaw: float = 0.0) -> "Part":
        """Return the part turned about z by *yaw* (rad), then shifted by *offset* (m)."""
        c, s = np.cos(yaw), np.sin(yaw)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return Part(self.color, self.corners @ turn.T + np.asarray(offset, dtype=float), self.normals @ turn.T)


def flat(color: str, triangles: ArrayLike) -> Part:
    """Return triangles (T, 3, 3) shaded facet by facet."""
    corners = np.asarray(triangles, dtype=float)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return Part(color, corners, np.repeat(normal[:, None], 3, axis=1))


def prism(color: str, outline: ArrayLike, bottom: float, top: float, chamfer: float = 0.0) -> Part:
    """Return a convex outline (K, 2), counter-clockwise, pulled from *bottom* to *top* with chamfered upper edge."""
    outline = np.asarray(outline, dtype=float)
    center = outline.mean(axis=0)
    reach = np.linalg.norm(outline - center, axis=1, keepdims=True)
    inner = center + (outline - center) * (1.0 - chamfer / reach)
    rings = [(outline, bottom), (outline, top - chamfer)] + ([(inner, top)] if chamfer else [])
    levels = [np.column_stack([ring, np.full(len(ring), z)]) for ring, z in rings]
    triangles = []
    for low, high in itertools.pairwise(levels):
        for k in range(len(outline)):
            n = (k + 1) % len(outline)
            triangles += [(low[k], low[n], high[n]), (low[k], high[n], high[k])]
    for k in range(1, len(outline) - 1):
        triangles += [(levels[0][0], levels[0][k + 1], levels[0][k]), (levels[-1][0], levels[-1][k], levels[-1][k + 1])]
    return flat(color, triangles)


def box(color: str, center: Sequence[float], half: Sequence[float], chamfer: float = 0.0) -> Part:
    """Return a box with its *center* and *half* sizes."""
    (x, y, z), (a, b, c) = center, half
    return prism(color, [(x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b)], z - c, z + c, chamfer)


def lathe(color: str, profile: Sequence[tuple[float, float]], sides: int = 12) -> Part:
    """Return the surface that *profile*, pairs (radius, z) from bottom to top, sweeps about the z axis."""
    angle = np.arange(sides + 1) * 2.0 * np.pi / sides
    around = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(sides + 1)])
    corners, normals = [], []
    for (r0, z0), (r1, z1) in itertools.pairwise(profile):
        out, up = z1 - z0, r0 - r1
        length = np.hypot(out, up)
        low, high = around * r0 + (0.0, 0.0, z0), around * r1 + (0.0, 0.0, z1)
        slope = around * (out / length) + (0.0, 0.0, up / length)
        for k in range(sides):
            if r0 > 0.0:
                corners.append((low[k], low[k + 1], high[k + 1]))
                normals.append((slope[k], slope[k + 1], slope[k + 1]))
            if r1 > 0.0:
                corners.append((low[k], high[k + 1], high[k]))
                normals.append((slope[k], slope[k + 1], slope[k]))
    return Part(color, np.array(corners), np.array(normals))


def propeller(color: str, radius: float, spin: float, yaw: float) -> list[Part]:
    """Return two twisted blades and a hub about the z axis; *spin* is +1 for counter-clockwise seen from above."""
    stations = np.array([0.10, 0.25, 0.45, 0.70, 0.90, 1.0])
    chords = np.array([0.11, 0.22, 0.27, 0.21, 0.13, 0.05]) * radius
    pitches = np.radians([30.0, 26.0, 20.0, 14.0, 11.0, 10.0])
    leading, trailing = [], []
    for station, chord, pitch in zip(stations, chords, pitches, strict=True):
        # a counter-clockwise blade pointing along x moves towards +y, with its leading edge up
        half = 0.5 * chord * np.array([0.0, spin * np.cos(pitch), np.sin(pitch)])
        root = np.array([station * radius, 0.0, 0.0])
        leading.append(root + half)
        trailing.append(root - half)
    thickness = np.array([0.0, 0.0, 0.0002])
    triangles = []
    for k in range(len(stations) - 1):
        quad = (trailing[k], trailing[k + 1], leading[k + 1], leading[k])
        upper = [p + thickness for p in (quad if spin > 0.0 else quad[::-1])]
        lower = [p - thickness for p in (quad[::-1] if spin > 0.0 else quad)]
        for a, b, c, d in (upper, lower):
            triangles += [(a, b, c), (a, c, d)]
    blade = flat(color, triangles)
    hub = lathe(color, [(0.0026, -0.0015), (0.0024, 0.0015), (0.0, 0.0019)], sides=8)
    return [blade.moved((0, 0, 0), yaw), blade.moved((0, 0, 0), yaw + np.pi), hub]


def guard(color: str, radius: float, outward: float) -> Part:
    """Return a half ring of *radius* around a motor, open towards the board; *outward* is its middle angle (rad)."""
    angles = outward + np.linspace(-0.56, 0.56, 15) * np.pi
    section = [(-0.0007, -0.0025), (0.0007, -0.0025), (0.0007, 0.0025), (-0.0007, 0.0025)]
    rings = [[((radius + r) * np.cos(a), (radius + r) * np.sin(a), z) for r, z in section] for a in angles]
    triangles = []
    for now, then in itertools.pairwise(rings):
        for k in range(4):
            n = (k + 1) % 4
            triangles += [(now[k], then[n], then[k]), (now[k], now[n], then[n])]
    return flat(color, np.array(triangles)[:, ::-1])


def octagon(half: float, cut: float) -> list[tuple[float, float]]:
    """Return a square of half size *half* with its corners cut by *cut*, counter-clockwise."""
    a, b = half, half - cut
    return [(a, -b), (a, b), (b, a), (-b, a), (-a, b), (-a, -b), (-b, -a), (b, -a)]


MOTORS = [(1, -1, 1), (-1, -1, -1), (-1, 1, 1), (1, 1, -1)]
"""M1 to M4: signs of x and y, and spin (+1 counter-clockwise seen from above)."""


def board(motor_xy: float) -> list[Part]:
    """Return the circuit board with arms, chips and one LED per arm: green in front, blue behind."""
    parts = [prism("board", octagon(0.0165, 0.006), -0.0008, 0.0008)]
    reach = motor_xy * np.sqrt(2.0)
    for sx, sy, _ in MOTORS:
        yaw = np.arctan2(sy, sx)
        parts.append(box("board", (reach / 2 + 0.004, 0, 0), (reach / 2 - 0.004, 0.0036, 0.0008)).moved((0, 0, 0), yaw))
        led = box("led_front" if sx > 0 else "led_back", (reach * 0.68, 0, 0.0014), (0.0024, 0.0022, 0.0008), 0.0004)
        parts.append(led.moved((0, 0, 0), yaw))
    parts += [box("chip", (0.004, 0.0, -0.0014), (0.0045, 0.0045, 0.0006))]
    parts += [box("metal", (0.0145, 0.0, -0.0020), (0.0028, 0.0038, 0.0012))]  # USB socket, in front
    for side in (-1, 1):
        parts.append(box("plastic", (0, 0.0122 * side, 0.0016), (0.0125, 0.0012, 0.0058)))
        parts.append(box("pin", (0, 0.0122 * side, 0.0080), (0.0118, 0.0004, 0.0008)))
        parts.append(box("pin", (0, 0.0122 * side, -0.0060), (0.0118, 0.0004, 0.0020)))
    return parts


def pack(length: float) -> tuple[list[Part], list[Part]]:
    """Return the battery with its wires, and the top plate with an arrow head pointing forward."""
    a = length / 2
    body = [
        box("battery", (0, 0, 0.0046), (a, 0.0100, 0.0036), 0.0008),
        box("plastic", (-a - 0.0012, 0, 0.0046), (0.0012, 0.0080, 0.0026)),
        box("wire", (-a - 0.0032, 0.0025, 0.0040), (0.0022, 0.0008, 0.0008)),
        box("board", (-a - 0.0032, -0.0025, 0.0040), (0.0022, 0.0008, 0.0008)),
    ]
    plate = [(-a + 0.002, -0.0085), (a - 0.007, -0.0085), (a + 0.001, 0.0), (a - 0.007, 0.0085), (-a + 0.002, 0.0085)]
    return body, [prism("accent", plate, 0.0082, 0.0094, 0.0004)]


def brushed() -> tuple[list[Part], list[Part]]:
    """Return body and accent of the Crazyflie 2.1+."""
    xy = 0.0325
    battery, accent = pack(0.030)
    body = board(xy) + battery
    motor = [
        lathe("leg", [(0.0, -0.0145), (0.0020, -0.0141), (0.0026, -0.0128), (0.0034, -0.0070)], sides=8),
        lathe("leg", [(0.0034, -0.0070), (0.0047, -0.0062), (0.0047, 0.0026), (0.0035, 0.0026)]),
        lathe("metal", [(0.0035, 0.0026), (0.0035, 0.0090), (0.0010, 0.0094), (0.0010, 0.0110)]),
    ]
    for k, (sx, sy, spin) in enumerate(MOTORS):
        body += [part.moved((xy * sx, xy * sy, 0)) for part in motor]
        blades = propeller("accent" if sx > 0 else "blade", 0.0234, spin, yaw=0.5 + 0.9 * k)
        (accent if sx > 0 else body).extend(part.moved((xy * sx, xy * sy, 0.012)) for part in blades)
    return body, accent


def brushless() -> tuple[list[Part], list[Part]]:
    """Return body and accent of the Crazyflie 2.1 Brushless with propeller guards."""
    xy = 0.03536
    battery, accent = pack(0.036)
    body = board(xy) + battery
    motor = [
        lathe("plastic", [(0.0, -0.0175), (0.0022, -0.0171), (0.0026, -0.0160), (0.0040, -0.0020)], sides=8),
        lathe("plastic", [(0.0040, -0.0020), (0.0060, -0.0014), (0.0060, 0.0022), (0.0030, 0.0022)]),
        lathe("metal", [(0.0030, 0.0022), (0.0056, 0.0032), (0.0056, 0.0082), (0.0042, 0.0094), (0.0010, 0.0096)]),
    ]
    for k, (sx, sy, spin) in enumerate(MOTORS):
        outward = np.arctan2(sy, sx)
        body += [part.moved((xy * sx, xy * sy, 0)) for part in motor]
        body.append(guard("guard", 0.0315, outward).moved((xy * sx, xy * sy, 0.0095)))
        for side in (-0.5, 0.0, 0.5):
            strut = box("guard", (0.0185, 0, 0.0), (0.0130, 0.0008, 0.0007))
            body.append(strut.moved((xy * sx, xy * sy, 0.0045), outward + side * np.pi))
            post = box("guard", (0.0315, 0, 0.006), (0.0008, 0.0012, 0.0020))
            body.append(post.moved((xy * sx, xy * sy, 0), outward + side * np.pi))
        blades = propeller("accent" if sx > 0 else "blade", 0.0275, spin, yaw=0.5 + 0.9 * k)
        (accent if sx > 0 else body).extend(part.moved((xy * sx, xy * sy, 0.012)) for part in blades)
    return body, accent


def obj_text(parts: Sequence[Part]) -> str:
    """Return *parts* as one Wavefront OBJ: positions, one palette coordinate per color, normals, faces."""
    names = list(PALETTE)
    position: dict[str, int] = {}
    normal: dict[str, int] = {}
    faces = []
    for part in parts:
        texture = names.index(part.color) + 1 if part.color in names else 1
        for corners, normals in zip(part.corners, part.normals, strict=True):
            face = []
            for p, n in zip(corners, normals, strict=True):
                # + 0.0 turns a negative zero into zero
                v = position.setdefault("v {:.6f} {:.6f} {:.6f}".format(*(np.round(p, 6) + 0.0)), len(position) + 1)
                m = normal.setdefault("vn {:.3f} {:.3f} {:.3f}".format(*(np.round(n, 3) + 0.0)), len(normal) + 1)
                face.append(f"{v}/{texture}/{m}")
            faces.append("f " + " ".join(face))
    cells = [f"vt {(k + 0.5) / len(names):.4f} 0.5" for k in range(len(names))]
    return "\n".join(["# written by make_assets.py", *position, *cells, *normal, *faces]) + "\n"


def palette_png() -> bytes:
    """Return the palette as an 8-bit RGB PNG, one cell per color from left to right."""
    row = b"\0" + b"".join(bytes(rgb) * CELL for rgb in PALETTE.values())

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", CELL * len(PALETTE), CELL, 8, 2, 0, 0, 0)
    image = chunk(b"IDAT", zlib.compress(row * CELL))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + image + chunk(b"IEND", b"")


def drawings() -> dict[str, str]:
    """Return the text of every mesh by file name."""
    files = {}
    for name, (body, accent) in {"crazyflie_2": brushed(), "crazyflie_21bl": brushless()}.items():
        files[f"{name}_body.obj"] = obj_text(body)
        files[f"{name}_accent.obj"] = obj_text(accent)
    return files


if __name__ == "__main__":
    ASSETS.mkdir(exist_ok=True)
    (ASSETS / "palette.png").write_bytes(palette_png())
    for name, text in drawings().items():
        (ASSETS / name).write_text(text)
