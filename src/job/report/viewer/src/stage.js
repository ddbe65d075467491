// The shapes, their light and the camera.

import {
    AmbientLight, BufferAttribute, BufferGeometry, CanvasTexture, ColorManagement, DirectionalLight, DoubleSide, Group,
    LinearSRGBColorSpace, Mesh, MeshLambertMaterial, PerspectiveCamera, Points, PointsMaterial, Raycaster, Scene, Sphere,
    Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { between } from "./shapes.js";
import { coloursOf } from "./colours.js";

const AMBIENT = 0.35;
const FIELD_OF_VIEW = 30;
// Of a surface that is seen through.
const CLEAR = 0x4477aa;
// Dots on a surface are drawn so much nearer that none of them is half hidden in it.
const NEARER = 0.995;
// One press of an arrow key.
const TURN = Math.PI / 12;

// Colours are shown as they are given, so that the legend's are the surface's.
ColorManagement.enabled = false;

export class Stage {
    constructor(canvas, shapes) {
        this.canvas = canvas;
        this.shapes = shapes;
        // A drawing that is kept can be printed and saved.
        this.renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
        this.renderer.outputColorSpace = LinearSRGBColorSpace;
        this.renderer.setClearColor(0xffffff);
        this.scene = new Scene();
        this.camera = new PerspectiveCamera(FIELD_OF_VIEW, 1);
        this.camera.up.set(0, 0, 1);
        const light = new DirectionalLight(0xffffff, (1 - AMBIENT) * Math.PI);
        light.position.set(0.3, 0.5, 1);
        this.camera.add(light, light.target);
        this.scene.add(this.camera, new AmbientLight(0xffffff, AMBIENT * Math.PI));
        this.parts = shapes.parts.map((part) => this.mesh(part));
        this.dots = shapes.dots.map((dots) => this.markers(dots));
        this.controls = this.turning();
        this.measure();
        this.resize();
        this.lookFrom([0, 1, 0]);
        new ResizeObserver(() => this.resize()).observe(canvas);
    }

    mesh(part) {
        const geometry = new BufferGeometry();
        geometry.setIndex(new BufferAttribute(part.triangles, 1));
        geometry.setAttribute("position", new BufferAttribute(part.points.at(-1).slice(), 3));
        geometry.computeVertexNormals();
        geometry.computeBoundingSphere();
        const clear = { color: CLEAR, transparent: true, opacity: 0.35, depthWrite: false };
        const look = part.clear ? clear : { vertexColors: true };
        const mesh = new Mesh(geometry, new MeshLambertMaterial({ side: DoubleSide, ...look }));
        mesh.visible = !part.clear;
        this.scene.add(mesh);
        return mesh;
    }

    // Round dots of one size in pixels; those behind a surface are faint.
    markers({ points, size, stops, values }) {
        const geometry = new BufferGeometry();
        geometry.setAttribute("position", new BufferAttribute(points, 3));
        geometry.setAttribute("color", new BufferAttribute(coloursOf(stops, values.at(-1)), 3));
        const look = { size: size * devicePixelRatio, sizeAttenuation: false, vertexColors: true, alphaTest: 0.5, map: disc() };
        const seen = new Points(geometry, new PointsMaterial(look));
        seen.material.onBeforeCompile = (shader) => {
            const nearer = `gl_Position = projectionMatrix * vec4(${NEARER} * mvPosition.xyz, 1.0);`;
            shader.vertexShader = shader.vertexShader.replace("#include <project_vertex>", `#include <project_vertex>\n${nearer}`);
        };
        const hidden = { ...look, depthTest: false, transparent: true, opacity: 0.2, alphaTest: 0.1 };
        const dots = new Group().add(seen, new Points(geometry, new PointsMaterial(hidden)));
        this.scene.add(dots);
        return dots;
    }

    // Dragging turns. The wheel zooms once the view was clicked, so that it does not catch a scrolling page.
    turning() {
        const controls = new OrbitControls(this.camera, this.canvas);
        controls.enableZoom = false;
        controls.addEventListener("change", () => this.draw());
        this.canvas.addEventListener("pointerdown", () => (controls.enableZoom = true));
        this.canvas.addEventListener("pointerleave", () => (controls.enableZoom = false));
        this.canvas.addEventListener("keydown", (event) => this.press(event));
        return controls;
    }

    press(event) {
        const turn = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
        if (turn) {
            event.preventDefault();
            const offset = this.camera.position.clone().sub(this.controls.target);
            const side = new Vector3(0, 0, 1).cross(offset).normalize();
            const height = offset.angleTo(this.camera.up);
            const down = Math.min(Math.max(height + turn[1] * TURN, 0.01), Math.PI - 0.01) - height;
            offset.applyAxisAngle(side, down).applyAxisAngle(this.camera.up, turn[0] * TURN);
            this.camera.position.copy(this.controls.target).add(offset);
            this.controls.update();
        }
    }

    // Shows all from a direction.
    lookFrom(direction) {
        const { center, radius } = this.bounds;
        const narrow = Math.min(1, this.camera.aspect);
        const distance = (1.05 * radius) / Math.sin((FIELD_OF_VIEW / 2) * (Math.PI / 180)) / narrow;
        this.controls.target.copy(center);
        this.camera.position.set(...direction).setLength(distance).add(center);
        this.controls.update();
    }

    // Shapes at share `t` of their way; the camera goes along.
    moveTo(t) {
        this.parts.forEach(({ geometry }, k) => {
            const { points } = this.shapes.parts[k];
            if (points.length > 1) {
                const { position } = geometry.attributes;
                position.array.set(between(points, t));
                position.needsUpdate = true;
                geometry.computeVertexNormals();
                geometry.computeBoundingSphere();
            }
        });
        this.dots.forEach((group, k) => {
            const { values, stops } = this.shapes.dots[k];
            const { color } = group.children[0].geometry.attributes;
            color.array.set(coloursOf(stops, between(values, t)));
            color.needsUpdate = true;
        });
        const before = this.bounds;
        this.measure();
        const { center, radius } = this.bounds;
        const offset = this.camera.position.clone().sub(this.controls.target).multiplyScalar(radius / before.radius);
        this.controls.target.add(center).sub(before.center);
        this.camera.position.copy(this.controls.target).add(offset);
        // A camera that has moved has drawn already.
        if (!this.controls.update()) {
            this.draw();
        }
    }

    // Where the shapes are now, and what the camera has to reach for that.
    measure() {
        this.bounds = new Sphere().makeEmpty();
        const solid = this.parts.filter((_, k) => !this.shapes.parts[k].clear);
        solid.forEach(({ geometry }) => this.bounds.union(geometry.boundingSphere));
        const { radius } = this.bounds;
        Object.assign(this.camera, { near: 0.01 * radius, far: 100 * radius });
        Object.assign(this.controls, { minDistance: 0.1 * radius, maxDistance: 20 * radius });
        this.camera.updateProjectionMatrix();
    }

    paint(colouring) {
        colouring.parts.forEach((paint, k) => {
            const values = paint instanceof Float32Array ? paint : new Float32Array(this.shapes.parts[k].points[0].length / 3);
            const stops = paint === values ? colouring.stops : [[0, colouring.classes[paint][1]]];
            this.parts[k].geometry.setAttribute("color", new BufferAttribute(coloursOf(stops, values), 3));
        });
        this.draw();
    }

    // The part and its vertex nearest to a place of the canvas, where there is one.
    pick(event) {
        const { width, height } = this.canvas.getBoundingClientRect();
        const place = new Vector2((2 * event.offsetX) / width - 1, 1 - (2 * event.offsetY) / height);
        const ray = new Raycaster();
        ray.setFromCamera(place, this.camera);
        const solid = this.parts.filter((mesh, k) => mesh.visible && !this.shapes.parts[k].clear);
        const [hit] = ray.intersectObjects(solid);
        if (!hit) {
            return null;
        }
        const { position } = hit.object.geometry.attributes;
        const distance = (v) => new Vector3().fromBufferAttribute(position, v).distanceTo(hit.point);
        const corners = [hit.face.a, hit.face.b, hit.face.c].sort((a, b) => distance(a) - distance(b));
        return { part: this.parts.indexOf(hit.object), vertex: corners[0] };
    }

    resize() {
        const { clientWidth, clientHeight } = this.canvas;
        if (clientWidth && clientHeight) {
            this.renderer.setPixelRatio(devicePixelRatio);
            this.renderer.setSize(clientWidth, clientHeight, false);
            this.camera.aspect = clientWidth / clientHeight;
            this.camera.updateProjectionMatrix();
            this.draw();
        }
    }

    draw() {
        this.renderer.render(this.scene, this.camera);
    }
}

function disc() {
    const canvas = Object.assign(document.createElement("canvas"), { width: 32, height: 32 });
    const context = canvas.getContext("2d");
    context.arc(16, 16, 13, 0, 2 * Math.PI);
    Object.assign(context, { fillStyle: "#fff", strokeStyle: "#444", lineWidth: 4 });
    context.fill();
    context.stroke();
    return new CanvasTexture(canvas);
}
