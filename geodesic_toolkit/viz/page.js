// The page of html.py: unpack the viewer and the scene, and show the value under the pointer.
const valueLabel = document.getElementById('gt-value');

function bytes(id) {
    const text = atob(document.getElementById(id).textContent);
    return Uint8Array.from(text, function (character) { return character.charCodeAt(0); });
}

async function inflated(packed) {
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
    return new Response(stream).text();
}

// k3d is an AMD module without dependencies: `make` returns its exports.
async function library() {
    let exported;
    window.define = function (name, dependencies, make) { exported = make(); };
    window.define.amd = {};
    const script = document.createElement('script');
    script.textContent = await inflated(bytes('gt-viewer'));
    document.head.append(script);
    return exported;
}

async function start() {
    const k3d = await library();
    const canvas = document.getElementById('canvasTarget');
    const viewer = await k3d.CreateK3DAndLoadBinarySnapshot(bytes('gt-scene').buffer, canvas);
    viewer.on(viewer.events.OBJECT_HOVERED, function (hit) {
        const item = viewer.getWorld().ObjectsListJson[hit.K3DIdentifier];
        if (!hit.face || !item || !item.attribute || !item.attribute.data.length) { return; }
        const corner = hit.face.map(function (v) {
            return [0, 1, 2].map(function (d) { return item.vertices.data[3 * v + d]; });
        });
        const minus = function (p, q) { return p.map(function (x, d) { return x - q[d]; }); };
        const dot = function (p, q) { return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]; };
        const u = minus(corner[1], corner[0]), v = minus(corner[2], corner[0]);
        const w = minus(hit.position, corner[0]);
        const area = dot(u, u) * dot(v, v) - dot(u, v) * dot(u, v);
        const s = area > 0 ? (dot(v, v) * dot(w, u) - dot(u, v) * dot(w, v)) / area : 0;
        const t = area > 0 ? (dot(u, u) * dot(w, v) - dot(u, v) * dot(w, u)) / area : 0;
        const at = hit.face.map(function (v) { return item.attribute.data[v]; });
        const value = (1 - s - t) * at[0] + s * at[1] + t * at[2];
        valueLabel.textContent = value.toPrecision(4) + ' ' + valueLabel.dataset.unit;
    });
}

start().catch(function (error) {
    console.error(error);
    valueLabel.textContent = 'The shape cannot be drawn: ' + error;
});
