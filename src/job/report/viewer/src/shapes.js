// What a report shows, as src/job/report/view3d.rs writes it: a description in JSON, and one block of numbers
// (zlib, then base64) into which the description points by [first, count].

export async function readShapes(figure) {
    const text = (kind) => figure.querySelector(`script[type="${kind}"]`).textContent;
    const numbers = await unpack(text("text/plain"));
    const floats = ([first, count]) => new Float32Array(numbers, 4 * first, count);
    const shapes = JSON.parse(text("application/json"));
    for (const part of shapes.parts) {
        const [first, count] = part.triangles;
        part.triangles = new Uint32Array(numbers, 4 * first, count);
        part.points = part.points.map(floats);
    }
    for (const colouring of shapes.colourings) {
        colouring.parts = colouring.parts.map((paint) => (Array.isArray(paint) ? floats(paint) : paint));
    }
    for (const dots of shapes.dots) {
        dots.points = floats(dots.points);
        dots.values = dots.values.map(floats);
    }
    return shapes;
}

async function unpack(base64) {
    const packed = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Response(stream).arrayBuffer();
}

// Numbers at share `t` of the way from the first array to the last.
export function between(arrays, t) {
    const [from, to] = [arrays[0], arrays[arrays.length - 1]];
    return from.map((value, k) => value + t * (to[k] - value));
}
