#!/bin/sh
# Makes the tetrahedral meshes tetra_bunny and tetra_cube (.node, .ele, .face) with TetGen 1.5 (Debian package tetgen).
#
#     sh make_tetras.sh
#
# Surfaces are kept as they are (-Y); the numbers behind -q and -a are chosen for about as many tetrahedra as the meshes
# of Bullet's SoftDemo have. The same version of TetGen gives the same bytes.
set -eu
cd "$(dirname "$0")"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The surface of the bunny as it is.
awk '
    /^v / { point[points++] = $2 " " $3 " " $4 }
    /^f / { for (i = 2; i <= 4; ++i) { split($i, part, "/"); corner[i] = part[1] - 1 }
            face[faces++] = corner[2] " " corner[3] " " corner[4] }
    END { print "OFF"; print points, faces, 0
          for (i = 0; i < points; ++i) print point[i]
          for (i = 0; i < faces; ++i) print 3, face[i] }
' bunny.obj >"$work/tetra_bunny.off"

# The surface of the cube from -1 to 1: 6 by 6 cells a side, the diagonals of neighbours crossed.
awk '
    function node(x, y, z,    key) {
        key = x " " y " " z
        if (!(key in number)) {
            number[key] = points
            point[points++] = sprintf("%.9g %.9g %.9g", 2 * x / n - 1, 2 * y / n - 1, 2 * z / n - 1)
        }
        return number[key]
    }
    function corner(axis, side, a, b) {
        return axis == 0 ? node(side, a, b) : axis == 1 ? node(b, side, a) : node(a, b, side)
    }
    function triangle(i, k, l, is_high) { face[faces++] = is_high ? i " " k " " l : i " " l " " k }
    BEGIN {
        n = 6; points = 0; faces = 0
        for (axis = 0; axis < 3; ++axis) for (high = 0; high < 2; ++high)
            for (a = 0; a < n; ++a) for (b = 0; b < n; ++b) {
                p = corner(axis, high * n, a, b); q = corner(axis, high * n, a + 1, b)
                r = corner(axis, high * n, a + 1, b + 1); s = corner(axis, high * n, a, b + 1)
                if ((a + b) % 2) { triangle(p, q, r, high); triangle(p, r, s, high) }
                else { triangle(p, q, s, high); triangle(q, r, s, high) }
            }
        print "OFF"; print points, faces, 0
        for (i = 0; i < points; ++i) print point[i]
        for (i = 0; i < faces; ++i) print 3, face[i]
    }
' >"$work/tetra_cube.off"

tetgen -pq3.0/0YzQ "$work/tetra_bunny.off"
tetgen -pq1.8/0a0.009YzQ "$work/tetra_cube.off"
for name in tetra_bunny tetra_cube; do
    for kind in node ele face; do
        grep -v '^#' "$work/$name.1.$kind" >"$name.$kind"
    done
done
