# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts as files for printing: STL, one a part, or 3MF with all parts side by side, or in their places. Millimetres; knows no Blender.

A part is (name, vertices, triangles): coordinates in millimetres (rows of three), corners by index (rows of three).
"""
import re
import struct
import xml.sax.saxutils
import zipfile

FORMATS = ("stl", "3mf", "assembled")
BETWEEN_MM = 5.0   # parts side by side in a 3MF
ROW_MM = 250.0     # a row of them is as long as that, or its one part
SHORTEST_NAME = "part"

_TYPES = ('<?xml version="1.0" encoding="UTF-8"?>\n<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
          '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
          '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>\n')
_RELATIONS = ('<?xml version="1.0" encoding="UTF-8"?>\n<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
              '<Relationship Id="model" Target="/3D/3dmodel.model" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>\n')


def single(number):
    """As an STL file has it: in single precision."""
    return struct.unpack("<f", struct.pack("<f", number))[0]


def onto_plate(vertices):
    """What moves points so that they stand on the plate (z from 0 up) about its middle."""
    low, high = ([f(v[axis] for v in vertices) for axis in range(3)] for f in (min, max))
    return -(low[0] + high[0]) / 2, -(low[1] + high[1]) / 2, -low[2]


def moved(vertices, shift):
    """Points after a move, in single precision."""
    return [tuple(single(x + s) for x, s in zip(v, shift)) for v in vertices]


def standing(vertices):
    """The same points, standing on the plate."""
    return moved(vertices, onto_plate(vertices))


def without_slivers(vertices, triangles):
    """Triangles by the first of equal points; those that single precision has made a line or a point are left out."""
    first = {}
    index = [first.setdefault(v, n) for n, v in enumerate(vertices)]
    merged = (tuple(index[corner] for corner in triangle) for triangle in triangles)
    return [triangle for triangle in merged if len(set(triangle)) == 3]


def stl(path, name, vertices, triangles):
    """Writes a binary STL."""
    rows = bytearray()
    for triangle in triangles:
        corners = [vertices[corner] for corner in triangle]
        rows += struct.pack("<12fH", *_normal(*corners), *(x for corner in corners for x in corner), 0)
    with open(path, "wb") as out:
        out.write(f"Transformables, millimetres: {name}".encode("ascii", "replace")[:80].ljust(80))
        out.write(struct.pack("<I", len(triangles)))
        out.write(rows)


def _normal(a, b, c):
    u, v = ([q - p for p, q in zip(a, other)] for other in (b, c))
    n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
    length = sum(x * x for x in n) ** 0.5
    return [x / length for x in n] if length > 0 else (0.0, 0.0, 0.0)


def three_mf(path, parts, assembled=False):
    """Writes a 3MF of all parts, side by side on the plate; or `assembled`: one thing whose parts stay where they are."""
    objects, items, places = [], [], [(0.0, 0.0)] * len(parts) if assembled else side_by_side([part[1] for part in parts])
    for number, ((name, vertices, triangles), (x, y)) in enumerate(zip(parts, places), 1):
        points = "".join(f'<vertex x="{a!r}" y="{b!r}" z="{c!r}"/>' for a, b, c in vertices)
        faces = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in triangles)
        objects.append(f'<object id="{number}" type="model" name={xml.sax.saxutils.quoteattr(name)}><mesh><vertices>{points}</vertices>'
                       f"<triangles>{faces}</triangles></mesh></object>")
        items.append(f'<item objectid="{number}" transform="1 0 0 0 1 0 0 0 1 {x:.6g} {y:.6g} 0"/>')
    if assembled:  # a slicer would arrange single items anew
        whole = "".join(f'<component objectid="{number}"/>' for number in range(1, len(parts) + 1))
        objects.append(f'<object id="{len(parts) + 1}" type="model" name="assembled"><components>{whole}</components></object>')
        items = [f'<item objectid="{len(parts) + 1}"/>']
    model = ('<?xml version="1.0" encoding="UTF-8"?>\n<model unit="millimeter" xml:lang="en-US" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">'
             f'<resources>{"".join(objects)}</resources><build>{"".join(items)}</build></model>\n')
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as out:
        for inside, text in (("[Content_Types].xml", _TYPES), ("_rels/.rels", _RELATIONS), ("3D/3dmodel.model", model)):
            out.writestr(zipfile.ZipInfo(inside, (2000, 1, 1, 0, 0, 0)), text, zipfile.ZIP_DEFLATED)  # the same parts: the same file


def side_by_side(all_vertices):
    """For each part where to put it, in rows, so that none overlap: [(x, y)]."""
    places, x, y, deepest = [], 0.0, 0.0, 0.0
    for vertices in all_vertices:
        low, high = ([f(v[axis] for v in vertices) for axis in range(2)] for f in (min, max))
        if x > 0 and x + high[0] - low[0] > ROW_MM:
            x, y, deepest = 0.0, y + deepest + BETWEEN_MM, 0.0
        places.append((x - low[0], y - low[1]))
        x += high[0] - low[0] + BETWEEN_MM
        deepest = max(deepest, high[1] - low[1])
    return places


def file_names(names, ending):
    """A file name a part, that every system takes; no two are the same, whatever the case of their letters."""
    taken, result = set(), []
    for name in names:
        base = re.sub(r"[^A-Za-z0-9._-]+", "_", name).strip("._-") or SHORTEST_NAME
        candidate, number = base, 1
        while candidate.lower() in taken:
            number += 1
            candidate = f"{base}_{number}"
        taken.add(candidate.lower())
        result.append(f"{candidate}.{ending}")
    return result
