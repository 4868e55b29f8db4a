// Draws the values of a mesh: colours from a table and sharp isolines, pixel by pixel.
//
// viser has meshes of one colour only. The values of the vertices are the colours of a hidden point
// cloud, whose buffer the mesh shares: an update is three bytes for a vertex. How values look is in
// the positions of another hidden cloud, row by row (style_rows in coding.py).
(() => {
    if (window.gtSurface) return;
    window.gtSurface = { updates: 0 };
    const SHAPE = '/shape', VALUES = '/values', STYLE = '/style', N_COLOURS = 64;

    const VERTEX_HEAD = `
attribute vec3 gtCode;
varying float gtValue;
varying float gtHidden;
varying float gtNone;`;
    const VERTEX_BODY = `
float gtNumber = dot(floor(gtCode * 255.0 + 0.5), vec3(1.0, 256.0, 65536.0));
gtHidden = gtNumber > 16777214.0 ? 1.0 : 0.0;
gtNone = gtNumber > 16777212.0 ? 1.0 : 0.0;
gtValue = gtNone > 0.5 ? 0.0 : gtNumber / 16777211.0;`;
    const FRAGMENT_HEAD = `
uniform vec3 gtTable[${N_COLOURS + 3}];
varying float gtValue;
varying float gtHidden;
varying float gtNone;`;
    // A line is 1.5 pixels wide, and fades where lines are closer than three pixels.
    const FRAGMENT_BODY = `
if (gtHidden > 0.0) discard;
vec3 gtEnds = gtTable[${N_COLOURS + 2}];
float gtPlace = clamp(gtValue, 0.0, 1.0) * ${N_COLOURS - 1}.0;
int gtBelow = int(min(floor(gtPlace), ${N_COLOURS - 2}.0));
vec3 gtColour = mix(gtTable[gtBelow], gtTable[gtBelow + 1], gtPlace - float(gtBelow));
if (gtEnds.z > 0.0) {
    float gtLevel = (gtEnds.x + gtValue * (gtEnds.y - gtEnds.x)) / gtEnds.z;
    float gtSlope = fwidth(gtLevel);
    float gtGap = abs(gtLevel - floor(gtLevel + 0.5)) / max(gtSlope, 1e-9);
    float gtInk = (1.0 - smoothstep(0.4, 1.4, gtGap)) * (1.0 - smoothstep(0.2, 0.4, gtSlope));
    if (abs(floor(gtLevel + 0.5)) > 0.5) gtColour = mix(gtColour, gtTable[${N_COLOURS + 1}], 0.8 * gtInk);
}
if (gtNone > 0.0) gtColour = gtTable[${N_COLOURS}];`;
    // Light from the camera, and without tone mapping: colours are those of the colour bar.
    const FRAGMENT_END = `
float gtFacing = abs(dot(normal, normalize(vViewPosition)));
gl_FragColor = vec4(gtColour * (0.35 + 0.65 * gtFacing), 1.0);`;

    function geometryOf(name) {
        let found = null;
        window.__viserMutable?.nodeRefFromName[name]?.traverse((item) => {
            if (!found && item.isPoints) found = item.geometry;
        });
        return found;
    }

    function meshOf(name) {
        let found = null;
        window.__viserMutable?.nodeRefFromName[name]?.traverse((item) => {
            if (!found && item.isMesh && item.material.isMeshStandardMaterial) found = item;
        });
        return found;
    }

    function paint(material) {
        const uniforms = { gtTable: { value: new Float32Array(3 * (N_COLOURS + 3)) } };
        material.onBeforeCompile = (shader) => {
            shader.uniforms.gtTable = uniforms.gtTable;
            shader.vertexShader = shader.vertexShader
                .replace('#include <common>', '#include <common>' + VERTEX_HEAD)
                .replace('#include <begin_vertex>', '#include <begin_vertex>' + VERTEX_BODY);
            shader.fragmentShader = shader.fragmentShader
                .replace('#include <common>', '#include <common>' + FRAGMENT_HEAD)
                .replace('#include <color_fragment>', '#include <color_fragment>' + FRAGMENT_BODY)
                .replace('#include <opaque_fragment>', FRAGMENT_END)
                .replace('#include <tonemapping_fragment>', '');
        };
        material.customProgramCacheKey = () => 'gtSurface';
        material.needsUpdate = true;
        material.userData.gt = uniforms;
    }

    function join() {
        const mesh = meshOf(SHAPE), values = geometryOf(VALUES), style = geometryOf(STYLE);
        const codes = values?.getAttribute('color'), rows = style?.getAttribute('position');
        if (!mesh || !codes || !rows || codes.count !== mesh.geometry.getAttribute('position').count) {
            return;
        }
        if (!mesh.material.userData.gt) paint(mesh.material);
        if (mesh.geometry.getAttribute('gtCode') !== codes) {
            mesh.geometry.setAttribute('gtCode', codes);
        }
        if (mesh.userData.gt) return;
        mesh.userData.gt = true;
        const drawn = window.gtSurface; // for tests, and to measure
        let version = -1;
        const isNew = () => mesh.geometry.getAttribute('gtCode')?.version !== version;
        mesh.onBeforeRender = () => {
            join();
            const uniforms = mesh.material.userData.gt;
            const table = geometryOf(STYLE)?.getAttribute('position');
            if (uniforms && table) uniforms.gtTable.value = table.array;
            if (isNew()) drawn.begun = performance.now();
        };
        mesh.onAfterRender = () => {
            if (!isNew()) return;
            version = mesh.geometry.getAttribute('gtCode')?.version;
            drawn.updates += 1;
            drawn.ended = performance.now();
        };
        window.__viserMutable.requestRender();
    }
    setInterval(join, 100); // nodes are made again when the connection is
})();
