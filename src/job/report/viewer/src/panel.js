// What stands around the view: colours, legend, the way from template to result, parts, and what is under the pointer.

import { colourAt, css } from "./colours.js";

// Of a template in anatomical position with z up; seen from the top, its front is below.
const SIDES = { front: [0, 1, 0], right: [1, 0, 0], back: [0, -1, 0], left: [-1, 0, 0], top: [0, 1e-3, 1], bottom: [0, 1e-3, -1] };

export class Panel {
    constructor(figure, stage, shapes) {
        this.stage = stage;
        this.shapes = shapes;
        this.legend = element("div", { className: "legend" });
        this.under = element("div", { className: "under" });
        figure.querySelector(".stage").append(this.legend, this.under);
        figure.querySelector(".stage").before(element("div", { className: "bar" }, this.colourings(), this.toggles(), this.way(), this.sides()));
        if (shapes.parts.filter((part) => !part.clear).length > 1) {
            figure.querySelector(".stage").after(this.parts());
        }
        stage.canvas.addEventListener("pointermove", (event) => this.point(event));
        stage.canvas.addEventListener("pointerleave", () => (this.under.textContent = ""));
        this.choose(shapes.colourings[0]);
    }

    colourings() {
        const choices = this.shapes.colourings.map((colouring, k) => {
            const input = element("input", { type: "radio", name: "colours", checked: k === 0, onchange: () => this.choose(colouring) });
            return element("label", {}, input, colouring.name);
        });
        return element("span", { className: "group" }, ...choices);
    }

    choose(colouring) {
        this.colouring = colouring;
        this.stage.paint(colouring);
        this.explain();
    }

    // A scale that colours and dots share is shown once.
    explain() {
        const { stops, title } = this.colouring;
        const dots = this.shapes.dots.filter((dots, k) => this.stage.dots[k].visible && dots.title !== title);
        this.legend.replaceChildren(...(stops ? scale(this.colouring) : classes(this.colouring)), ...dots.flatMap(scale));
    }

    // Dots and surfaces seen through.
    toggles() {
        const toggle = (name, object) => {
            const input = element("input", { type: "checkbox", checked: object.visible });
            input.onchange = () => {
                object.visible = input.checked;
                this.stage.draw();
                this.explain();
            };
            return element("label", {}, input, name);
        };
        const clear = this.shapes.parts.flatMap((part, k) => (part.clear ? [toggle(part.name, this.stage.parts[k])] : []));
        const dots = this.shapes.dots.map(({ name }, k) => toggle(name, this.stage.dots[k]));
        return element("span", { className: "group" }, ...dots, ...clear);
    }

    way() {
        if (!this.shapes.ends) {
            return "";
        }
        const [from, to] = this.shapes.ends;
        const slider = element("input", { type: "range", min: 0, max: 1, step: 0.01, value: 1, title: `${from} to ${to}` });
        slider.oninput = () => this.stage.moveTo(Number(slider.value));
        return element("label", { className: "group" }, from, slider, to);
    }

    sides() {
        const buttons = Object.entries(SIDES).map(([name, direction]) =>
            element("button", { type: "button", onclick: () => this.stage.lookFrom(direction) }, name));
        return element("span", { className: "group" }, ...buttons);
    }

    // A list with a box for each part.
    parts() {
        const solid = this.shapes.parts.filter((part) => !part.clear);
        const inputs = solid.map(() => element("input", { type: "checkbox", checked: true }));
        const show = () => {
            inputs.forEach((input, k) => (this.stage.parts[k].visible = input.checked));
            this.stage.draw();
        };
        inputs.forEach((input) => (input.onchange = show));
        const all = (checked) => () => {
            inputs.forEach((input) => (input.checked = checked));
            show();
        };
        const button = (text, checked) => element("button", { type: "button", onclick: all(checked) }, text);
        const boxes = solid.map((part, k) => element("label", {}, inputs[k], part.name));
        return element("details", { className: "parts" }, element("summary", {}, `${boxes.length} parts`),
            element("p", {}, button("show all", true), button("hide all", false)), element("div", {}, ...boxes));
    }

    point(event) {
        const found = event.buttons === 0 && this.stage.pick(event);
        if (!found) {
            this.under.textContent = "";
            return;
        }
        const paint = this.colouring.parts[found.part];
        const value = paint instanceof Float32Array ? number(paint[found.vertex]) : this.colouring.classes[paint][0];
        const { name } = this.shapes.parts[found.part];
        this.under.textContent = name === value ? name : `${name}: ${value}`;
    }
}

// The title and a band of colours with its values.
function scale({ title, stops }) {
    const [low, high] = [stops[0][0], stops[stops.length - 1][0]];
    const place = (value) => (100 * (value - low)) / (high - low);
    const band = element("div", { className: "band" });
    const colours = Array.from({ length: 33 }, (_, k) => css(colourAt(stops, low + (k / 32) * (high - low))));
    band.style.background = `linear-gradient(to right, ${colours.join(", ")})`;
    const values = element("div", { className: "values" }, ...stops.map(([value]) => {
        const label = element("span", {}, number(value));
        label.style.left = `${place(value)}%`;
        return label;
    }));
    return [element("div", {}, title), band, values];
}

// The title and a colour for each name.
function classes({ title, classes }) {
    const lines = classes.map(([name, colour]) => {
        const square = element("i", { className: "colour" });
        square.style.background = css(colour);
        return element("div", {}, square, name);
    });
    return title ? [element("div", {}, title), ...lines] : [];
}

function number(value) {
    return Number.isNaN(value) ? "not known" : String(Number(value.toPrecision(3)));
}

function element(name, properties, ...content) {
    const made = Object.assign(document.createElement(name), properties);
    made.append(...content);
    return made;
}
