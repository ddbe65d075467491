// Fills the figure of class view3d in a report with a view that can be turned.

import { readShapes } from "./shapes.js";
import { Stage } from "./stage.js";
import { Panel } from "./panel.js";

async function start(figure) {
    try {
        const shapes = await readShapes(figure);
        const stage = new Stage(figure.querySelector("canvas"), shapes);
        new Panel(figure, stage, shapes);
        performance.mark("moulage-view");
    } catch (problem) {
        // Without WebGL the still pictures below say the same.
        figure.classList.add("missing");
        figure.querySelector("figcaption").textContent = `No view that turns: ${problem.message}`;
        document.querySelectorAll("details.still").forEach((still) => (still.open = true));
    }
}

start(document.querySelector("figure.view3d"));
