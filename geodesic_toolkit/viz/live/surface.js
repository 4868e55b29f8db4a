// Draws the values of a mesh: colours from a table and sharp isolines, pixel by pixel.
//
// viser has meshes of one colour only. The values of the vertices are the colours of a hidden point
// cloud, whose buffer the mesh shares: an update is three bytes for a vertex. How values look is in
// the positions of another hidden cloud, row by row (style_rows in coding.py).
(() => {
    if (window.gtSurface) return;
    window.gtSurface = { updates: 0 };
    const SHAPE = '/shape', VALUES = '/values', STYLE = '/style', N_COLOURS = 64;

    // The material of viser computes lights and shadows of every vertex and pixel; these do not.
    const VERTEX = `
attribute vec3 gtCode;
varying vec3 gtShown; // the value from 0 to 1; more than 0 where there is none; where it is hidden
varying vec3 gtNormal;
varying vec3 gtToCamera;
void main() {
    float number = dot(floor(gtCode * 255.0 + 0.5), vec3(1.0, 256.0, 65536.0));
    float none = number > 16777212.0 ? 1.0 : 0.0;
    gtShown = vec3(none > 0.5 ? 0.0 : number / 16777211.0, none, number > 16777214.0 ? 1.0 : 0.0);
    gtNormal = normalMatrix * normal;
    #include <begin_vertex>
    #include <project_vertex>
    gtToCamera = -mvPosition.xyz;
}`;
    // A line is 1.5 pixels wide, and fades where lines are closer than three pixels. Light comes from
    // the camera, and there is no tone mapping: colours are those of the colour bar.
    const FRAGMENT = `
uniform vec3 gtTable[${N_COLOURS + 3}];
varying vec3 gtShown;
varying vec3 gtNormal;
varying vec3 gtToCamera;
void main() {
    if (gtShown.z > 0.0) discard;
    vec3 ends = gtTable[${N_COLOURS + 2}];
    float place = clamp(gtShown.x, 0.0, 1.0) * ${N_COLOURS - 1}.0;
    int below = int(min(floor(place), ${N_COLOURS - 2}.0));
    vec3 colour = mix(gtTable[below], gtTable[below + 1], place - float(below));
    if (ends.z > 0.0) {
        float level = (ends.x + gtShown.x * (ends.y - ends.x)) / ends.z;
        float slope = fwidth(level);
        float gap = abs(level - floor(level + 0.5)) / max(slope, 1e-9);
        float ink = (1.0 - smoothstep(0.4, 1.4, gap)) * (1.0 - smoothstep(0.2, 0.4, slope));
        if (abs(floor(level + 0.5)) > 0.5) colour = mix(colour, gtTable[${N_COLOURS + 1}], 0.8 * ink);
    }
    if (gtShown.y > 0.0) colour = gtTable[${N_COLOURS}];
    float facing = abs(dot(normalize(gtNormal), normalize(gtToCamera)));
    gl_FragColor = vec4(colour * (0.35 + 0.65 * facing), 1.0);
    #include <colorspace_fragment>
}`;

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
            shader.vertexShader = VERTEX;
            shader.fragmentShader = FRAGMENT;
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
