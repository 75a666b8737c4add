// Draws what `relievo export --target wgsl --write hit` has written, as a mesh of three.js:
//
//     const carved = await loadRelievo('torus/');
//     scene.add(carved);
//
// Needs WebGPURenderer on WebGPU. See docs/three.md.

import {
    BackSide, BufferAttribute, BufferGeometry, Color, InterleavedBuffer, InterleavedBufferAttribute,
    Mesh, MeshPhysicalNodeMaterial, Node, StorageBufferAttribute, Uint32BufferAttribute,
} from 'three/webgpu';
import {
    Fn, attribute, cameraFar, cameraNear, cameraProjectionMatrix, cameraWorldMatrix, max, modelViewMatrix,
    modelWorldMatrix, modelWorldMatrixInverse, overrideNodes, positionGeometry, positionLocal,
    screenCoordinate, select, storage, transformNormalToView, uniform, vec4, viewZToLogarithmicDepth, viewport,
} from 'three/tsl';

const CLASSES = ['cap', 'wall', 'bevel', 'floor'];

// The ray of a pixel, in the space of the object, for perspective and orthographic cameras. All facets
// get the same ray, so that no pixel falls between two of them.
const PIXEL = `
struct RelievoSurface {
    surface_class: u32,
    position: vec3<f32>,
    normal: vec3<f32>,
    mesh_normal: vec3<f32>,
    tangent: vec4<f32>,
    uv: vec2<f32>,
    uv_right: vec2<f32>,
    uv_down: vec2<f32>,
    depth_fraction: f32,
    object: u32,
    layer: u32,
}

fn relievo_surface(pixel: vec2<f32>, viewport: vec4<f32>, projection: mat4x4<f32>, to_view: mat4x4<f32>, to_object: mat4x4<f32>, near: f32, facet: u32) -> RelievoSurface {
    let at = (pixel - viewport.xy) / viewport.zw * vec2<f32>(2.0, -2.0) - vec2<f32>(1.0, -1.0);
    let is_parallel = projection[3][3] != 0.0;
    // Per pixel, at distance 1.
    let size = vec2<f32>(2.0, -2.0) / (viewport.zw * vec2<f32>(projection[0][0], projection[1][1]));
    var start = vec3<f32>();
    var through = vec3<f32>((at + projection[2].xy) / vec2<f32>(projection[0][0], projection[1][1]), -1.0);
    var least = near;
    if is_parallel {
        // From a little before the near plane: hits must lie behind it.
        least = abs(size.y);
        start = vec3<f32>((at - projection[3].xy) / vec2<f32>(projection[0][0], projection[1][1]), least - near);
        through = vec3<f32>(0.0, 0.0, -1.0);
    }
    let origin = (to_object * vec4<f32>(start, 1.0)).xyz;
    let along = (to_object * vec4<f32>(through, 0.0)).xyz;
    let forward = -normalize(vec3<f32>(to_view[0].z, to_view[1].z, to_view[2].z));
    let scale = dot(along, forward);
    // A parallel ray is as wide everywhere as a diverging one is at the object's origin.
    let width = select(1.0, 1.0 / max(-dot(origin, forward), least * scale), is_parallel) / scale;
    let right = (to_object * vec4<f32>(size.x, 0.0, 0.0, 0.0)).xyz * width;
    let down = (to_object * vec4<f32>(0.0, size.y, 0.0, 0.0)).xyz * width;
    let direction = normalize(along);
    let hit = PREFIX_hit(origin, direction, forward, right, down, least * scale, facet);
    return RelievoSurface(hit.surface_class, origin + direction * hit.t, hit.normal, hit.mesh_normal, hit.tangent, hit.uv, hit.uv_right, hit.uv_down, hit.depth_fraction, hit.object, hit.layer);
}
`;

const MEMBERS = {
    surface_class: 'uint', position: 'vec3', normal: 'vec3', mesh_normal: 'vec3', tangent: 'vec4',
    uv: 'vec2', uv_right: 'vec2', uv_down: 'vec2', depth_fraction: 'float', object: 'uint', layer: 'uint',
};

// What the pixel hits over the facet that is drawn. Its members are nodes: hit.get('normal').
export class RelievoHitNode extends Node {

    static get type() {
        return 'RelievoHitNode';
    }

    // `buffers`: storage nodes by the names of their variables in the exported `code`.
    constructor(code, prefix, buffers) {
        super('RelievoSurface');
        const declared = /@group\(\d+\) @binding\(\d+\)\s*var<storage> (\w+): \w+;/g;
        this.code = code.replace(declared, '') + PIXEL.replace('PREFIX', prefix);
        this.names = Object.keys(buffers);
        this.buffers = Object.values(buffers);
        const facet = attribute('facet', 'uint');
        // Three 0.187 asks for this before it inlines varyings, and sets it nowhere.
        facet.isAttributeNode = true;
        this.inputs = [
            [screenCoordinate, 'vec2'], [viewport.floor(), 'vec4'], [cameraProjectionMatrix, 'mat4'],
            [modelViewMatrix, 'mat4'], [modelWorldMatrixInverse.mul(cameraWorldMatrix), 'mat4'],
            [cameraNear, 'float'], [facet, 'uint'],
        ];
    }

    isCacheable() {
        return false;
    }

    getMemberType(builder, name) {
        return MEMBERS[name] ?? 'void';
    }

    setup(builder) {
        const properties = builder.getNodeProperties(this);
        [...this.buffers, ...this.inputs.map(([node]) => node)].forEach((node, i) => properties[`node${i}`] = node);
    }

    // Three binds the buffers: the exported code gets the names that it gives them.
    generate(builder) {
        const arrays = this.buffers.map((buffer) => buffer.build(builder));
        const inputs = this.inputs.map(([node, type]) => node.build(builder, type));
        const code = builder.getCodeFromNode(this, 'code');
        code.code = this.names.reduce((text, name, i) => text
            .replaceAll(`${name}.at[`, `${arrays[i]}[`)
            .replaceAll(`${name}.at`, `${arrays[i]}[0]`), this.code);
        return `relievo_surface( ${inputs.join(', ')} )`;
    }

}

async function file(folder, name) {
    const answer = await fetch(new URL(name, new URL(folder, document.baseURI)));
    if (!answer.ok) throw new Error(`${answer.url}: ${answer.status} ${answer.statusText}`);
    return answer;
}

// Returns the mesh of an exported folder. Its material gets the nodes of the carved surface, and
// material.classColors, a colour for each class: cap, wall, bevel, floor;
// material.hit, a node with what the pixel hits, for nodes of your own: material.hit.get('uv').
export async function loadRelievo(folder, material = new MeshPhysicalNodeMaterial()) {
    const layout = await (await file(folder, 'layout.json')).json();
    if (!layout.hull) throw new Error(`${folder}: export it with --target wgsl --write hit`);
    const bytes = async (name) => (await file(folder, name)).arrayBuffer();
    const entries = layout.bind_groups[0].entries.filter((entry) => entry.name !== 'frames');
    const [code, vertices, indices, ...contents] = await Promise.all([
        file(folder, 'hit.wgsl').then((answer) => answer.text()),
        bytes(layout.hull.vertices.file),
        bytes(layout.hull.indices.file),
        ...entries.map((entry) => bytes(entry.file)),
    ]);
    const prefix = /fn (\w+)_hit\(/.exec(code)[1];
    const typePrefix = /struct (\w+)Hit \{/.exec(code)[1];
    const buffers = Object.fromEntries(entries.map(({ name, element }, i) => {
        const words = new StorageBufferAttribute(new Uint32Array(contents[i]), 1);
        const type = element === 'u32' ? 'uint' : typePrefix + element;
        return [`${prefix}_${name}`, storage(words, type, words.count).toReadOnly()];
    }));

    const parameters = new DataView(contents[entries.findIndex((entry) => entry.name === 'object')]);
    const { fields } = layout.structs.find((described) => described.name === 'Object');
    material.classColors = Object.fromEntries(CLASSES.map((name) => {
        const { offset } = fields.find((field) => field.name === `${name}_color`);
        const [red, green, blue] = [0, 4, 8].map((i) => parameters.getFloat32(offset + i, true));
        return [name, new Color().setRGB(red, green, blue)];
    }));
    material.hit = new RelievoHitNode(code, prefix, buffers).toVar('relievoHit');
    setNodes(material);

    const mesh = new Mesh(hullGeometry(layout.hull, vertices, indices), material);
    mesh.name = layout.object;
    mesh.position.fromArray(layout.placement.translation);
    mesh.quaternion.fromArray(layout.placement.rotation);
    mesh.scale.setScalar(layout.placement.scale);
    mesh.castShadow = mesh.receiveShadow = true;
    return mesh;
}

// The hulls of all facets. They have no normals: lights ask the material for them.
function hullGeometry(hull, vertices, indices) {
    const geometry = new BufferGeometry();
    const words = hull.stride / 4;
    const floats = new InterleavedBuffer(new Float32Array(vertices), words);
    for (const { name, format, offset } of hull.attributes) {
        if (format === 'uint32') {
            const all = new Uint32Array(vertices);
            const own = Uint32Array.from({ length: hull.vertices.count }, (_, i) => all[i * words + offset / 4]);
            geometry.setAttribute(name, new Uint32BufferAttribute(own, 1));
        } else {
            geometry.setAttribute(name, new InterleavedBufferAttribute(floats, 3, offset / 4));
        }
    }
    geometry.setIndex(new BufferAttribute(new Uint32Array(indices), 1));
    return geometry;
}

// Gives a material the surface that its `hit` finds.
function setNodes(material) {
    const { hit } = material;
    const position = hit.get('position');
    const surfaceClass = hit.get('surface_class');
    const clip = cameraProjectionMatrix.mul(modelViewMatrix).mul(vec4(position, 1));
    // Hulls may be in front of what they contain, or behind: what is turned away is drawn, once per pixel.
    material.side = material.shadowSide = BackSide;
    // A pixel's width beyond the facet: then its edges are covered, whatever the device's rules.
    material.positionNode = Fn(() => {
        const distance = cameraProjectionMatrix.mul(modelViewMatrix).mul(vec4(positionGeometry, 1)).w.abs();
        const height = distance.mul(2).div(cameraProjectionMatrix.element(1).y.mul(viewport.w));
        const scale = modelWorldMatrix.element(0).xyz.length()
            .min(modelWorldMatrix.element(1).xyz.length(), modelWorldMatrix.element(2).xyz.length());
        return positionGeometry.add(attribute('outward', 'vec3').mul(height.div(scale)));
    })();
    material.maskNode = surfaceClass.notEqual(0);
    material.depthNode = Fn(({ renderer, camera }) => {
        if (renderer.logarithmicDepthBuffer && !camera.isOrthographicCamera) {
            return viewZToLogarithmicDepth(clip.w.negate(), cameraNear, cameraFar);
        }
        return clip.z.div(clip.w);
    })();
    material.colorNode = CLASSES.slice(1).reduce(
        (color, name, i) => select(surfaceClass.equal(i + 2), uniform(material.classColors[name]), color),
        uniform(material.classColors.cap),
    );
    material.normalNode = transformNormalToView(hit.get('normal')).normalize();
    // Lights, shadows, fog and environment ask for the position in the fragment stage.
    material.contextNode = overrideNodes([[positionLocal, position]], null, 'fragment');
}
