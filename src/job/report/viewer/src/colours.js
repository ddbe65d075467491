// Colours of values: stops are [value, [red, green, blue]], 0 to 1 each, with rising values.

const UNKNOWN = [0.55, 0.55, 0.55];

export function colourAt(stops, value) {
    if (Number.isNaN(value)) {
        return UNKNOWN;
    }
    const above = stops.findIndex(([stop]) => value < stop);
    if (above <= 0) {
        return stops[above === 0 ? 0 : stops.length - 1][1];
    }
    const [[low, from], [high, to]] = [stops[above - 1], stops[above]];
    const share = (value - low) / (high - low);
    return from.map((channel, k) => channel + share * (to[k] - channel));
}

export function coloursOf(stops, values) {
    const colours = new Float32Array(3 * values.length);
    values.forEach((value, k) => colours.set(colourAt(stops, value), 3 * k));
    return colours;
}

export function css(colour) {
    return `rgb(${colour.map((channel) => Math.round(255 * channel)).join(" ")})`;
}
