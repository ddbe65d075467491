// Draws a .glb in a page, as three.js reads it.
import * as three from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";

const renderer = new three.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
renderer.setSize(innerWidth, innerHeight);
document.body.append(renderer.domElement);
let root, mixer;

// Takes the scene; seen along `direction`, with what `shown` names in the middle.
globalThis.open_scene = async (base64, direction, shown) => {
  const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  const file = await new GLTFLoader().parseAsync(bytes.buffer, "");
  root = new three.Scene();
  root.background = new three.Color(0xffffff);
  root.add(file.scene, new three.HemisphereLight(0xffffff, 0x806050, 2.5));
  mixer = new three.AnimationMixer(file.scene);
  for (const clip of file.animations) {
    const action = mixer.clipAction(clip).setLoop(three.LoopOnce);
    action.clampWhenFinished = true;
    action.play();
  }
  root.updateMatrixWorld(true);
  const box = new three.Box3();
  for (const name of shown) box.expandByObject(root.getObjectByName(name), true);
  const sphere = box.getBoundingSphere(new three.Sphere());
  const camera = new three.PerspectiveCamera(30, innerWidth / innerHeight, sphere.radius / 50, sphere.radius * 50);
  camera.position.copy(sphere.center).addScaledVector(new three.Vector3(...direction).normalize(), 4.6 * sphere.radius);
  camera.lookAt(sphere.center);
  camera.add(new three.DirectionalLight(0xffffff, 1.5));
  root.add(camera);
  globalThis.camera = camera;
};

globalThis.draw_at = (seconds) => {
  mixer.setTime(seconds);
  root.updateMatrixWorld(true);
  renderer.render(root, globalThis.camera);
};

// Where the vertices of a mesh lie in the world as it is drawn, one row each.
globalThis.vertices_of = (name) => {
  let mesh = root.getObjectByName(name);
  if (!mesh.isMesh) mesh = mesh.children.find((child) => child.isMesh);
  const positions = mesh.geometry.getAttribute("position");
  return Array.from({ length: positions.count }, (_, i) => {
    const p = mesh.getVertexPosition(i, new three.Vector3());
    return p.applyMatrix4(mesh.matrixWorld).toArray();
  });
};
