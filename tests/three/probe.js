// Draws the example's scene into floating-point targets. `window.example` has the page's variables.

import * as THREE from 'three/webgpu';
import { mrt, normalWorld, output, positionWorld, vec4 } from 'three/tsl';
import { loadRelievo } from './relievo.js';

const { renderer, scene, camera, carved, cube } = window.example;

// Frames go on, and with them the lights, but draw nothing by themselves.
renderer.setAnimationLoop(null);
window.requestAnimationFrame = window.frame.ask;
window.frame.ask(window.frame.next);
const frame = () => new Promise((done) => window.frame.ask(() => window.frame.ask(done)));

// One target gets the light, or the normal that lights see; the other the position that they see, and
// what is there: 1 more than the class, or 10.
const targets = (what) => mrt({
    output: window.wantsNormals ? vec4(normalWorld, 1) : output,
    surface: vec4(positionWorld, what),
});
const prepared = (mesh) => {
    mesh.material.mrtNode = targets(mesh.material.hit.get('surface_class').toFloat().add(1));
    return mesh;
};
prepared(carved);
cube.material.mrtNode = targets(10);

// Bytes in base64.
function encoded(bytes) {
    let text = '';
    for (let i = 0; i < bytes.length; i += 4096) text += String.fromCharCode(...bytes.subarray(i, i + 4096));
    return btoa(text);
}

window.probe = {
    THREE,
    load: async (folder) => prepared(await loadRelievo(folder)),

    // Draws a picture and returns both targets, rows from the top.
    draw: async (width, height, from) => {
        const target = new THREE.RenderTarget(width, height, { count: 2, type: THREE.FloatType });
        target.textures[0].name = 'output';
        target.textures[1].name = 'surface';
        await frame();
        renderer.setMRT(mrt({ output, surface: vec4(0) }));
        renderer.setRenderTarget(target);
        renderer.render(scene, from);
        renderer.setRenderTarget(null);
        renderer.setMRT(null);
        const both = [];
        for (const index of [0, 1]) {
            const floats = await renderer.readRenderTargetPixelsAsync(target, 0, 0, width, height, index);
            both.push(encoded(new Uint8Array(floats.buffer, floats.byteOffset, 16 * width * height)));
        }
        target.dispose();
        return both.join(' ');
    },

    // Draws what the page shows and returns it as PNG.
    show: async () => {
        cube.material.mrtNode = carved.material.mrtNode = null;
        await frame();
        renderer.render(scene, camera);
        return renderer.domElement.toDataURL().split(',')[1];
    },
};
