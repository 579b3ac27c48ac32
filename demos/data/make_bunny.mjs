// Makes bunny.obj: the Stanford bunny of the npm package `bunny`, reduced to 902 triangles with meshoptimizer, turned
// and scaled to the place and size that the bunny scenes expect.
//
//     npm install --no-save --no-package-lock bunny@1.0.1 meshoptimizer@1.3.0
//     node make_bunny.mjs bunny.obj
//
// The same versions give the same bytes. The script stops when the result is not closed, not manifold, not turned
// outward, or not of the expected size.

import { writeFileSync } from "node:fs";
import bunny from "bunny";
import { MeshoptSimplifier } from "meshoptimizer";

const TRIANGLES = 902;
const VERTICES = 453;
const HEIGHT = 1.443; // of the bounding box along y, m
const CENTRE = [0, 0.055, 0.028]; // of the bounding box, m

function check(condition, message) {
    if (!condition) {
        console.error("make_bunny: " + message);
        process.exit(1);
    }
}

function bounds(points) {
    const axes = [0, 1, 2];
    return {
        min: axes.map((k) => Math.min(...points.map((p) => p[k]))),
        max: axes.map((k) => Math.max(...points.map((p) => p[k]))),
    };
}

function signedVolume(points, faces) {
    let sum = 0;
    for (const [ia, ib, ic] of faces) {
        const a = points[ia], b = points[ib], c = points[ic];
        sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return sum / 6;
}

// Each directed edge once and its opposite once: closed, and of one orientation.
function isClosed(faces) {
    const edges = new Set();
    for (const f of faces) {
        for (let k = 0; k < 3; ++k) {
            const edge = f[k] + " " + f[(k + 1) % 3];
            if (edges.has(edge)) { return false; }
            edges.add(edge);
        }
    }
    return [...edges].every((edge) => edges.has(edge.split(" ").reverse().join(" ")));
}

// The faces around each vertex make one fan: no two parts of the surface touch in a single vertex.
function isManifold(vertexCount, faces) {
    const next = Array.from({ length: vertexCount }, () => new Map());
    for (const [a, b, c] of faces) {
        next[a].set(b, c);
        next[b].set(c, a);
        next[c].set(a, b);
    }
    return next.every((fan) => {
        if (fan.size === 0) { return false; }
        const start = fan.keys().next().value;
        let at = start, steps = 0;
        do {
            at = fan.get(at);
            ++steps;
        } while (at !== undefined && at !== start && steps <= fan.size);
        return at === start && steps === fan.size;
    });
}

const output = process.argv[2];
check(output !== undefined, "usage: node make_bunny.mjs OUTPUT.obj");

await MeshoptSimplifier.ready;
const [kept] = MeshoptSimplifier.simplify(
    Uint32Array.from(bunny.cells.flat()), Float32Array.from(bunny.positions.flat()), 3, 3 * TRIANGLES, 1.0,
    ["Regularize"]); // even triangles: their edges become the links

// Only the vertices in use, in their old order.
const used = [...new Set(kept)].sort((a, b) => a - b);
const newIndex = new Map(used.map((old, index) => [old, index]));
const faces = [];
for (let i = 0; i < kept.length; i += 3) {
    faces.push([newIndex.get(kept[i]), newIndex.get(kept[i + 1]), newIndex.get(kept[i + 2])]);
}

// A quarter turn about y lets the head, at -x in the scan, look along +z.
const turned = used.map((old) => {
    const [x, y, z] = bunny.positions[old];
    return [z, y, -x];
});
const { min, max } = bounds(turned);
const scale = HEIGHT / (max[1] - min[1]);
const points = turned.map((p) => p.map((value, k) => scale * (value - 0.5 * (min[k] + max[k])) + CENTRE[k]));
const lines = points.map((p) => "v " + p.map((value) => value.toFixed(6)).join(" "));

check(points.length === VERTICES, `${points.length} vertices, expected ${VERTICES}`);
check(faces.length === TRIANGLES, `${faces.length} triangles, expected ${TRIANGLES}`);
check(new Set(lines).size === VERTICES, "two vertices coincide");
check(isClosed(faces), "the surface is not closed");
check(isManifold(points.length, faces), "the surface is not manifold");
check(points.length - (3 * faces.length) / 2 + faces.length === 2, "the surface is not a sphere");
check(signedVolume(points, faces) > 0, "the surface is turned inward");

writeFileSync(output, [
    "# Stanford bunny, 453 vertices, 902 triangles, closed, outward. Made by make_bunny.mjs; see README.md.",
    ...lines,
    ...faces.map((f) => "f " + f.map((index) => index + 1).join(" ")),
    "",
].join("\n"));
const size = bounds(points);
console.log(`${output}: volume ${signedVolume(points, faces).toFixed(4)} m^3, from (${size.min.map((v) => v.toFixed(3))}) ` +
    `to (${size.max.map((v) => v.toFixed(3))})`);
