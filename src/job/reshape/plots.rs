//! Plots of the report as SVG text, through the `plotters` crate.

use plotters::prelude::*;

use super::report::Report;

/// Width and height of a plot.
const SIZE: (u32, u32) = (440, 300);
/// Bins of the marker histogram.
const BINS: usize = 30;

const BEFORE: RGBColor = RGBColor(150, 150, 160);
const AFTER: RGBColor = RGBColor(31, 95, 191);
const LARGEST: RGBColor = RGBColor(200, 90, 30);

/// What a plot gives up with; never seen by users, since nothing here can fail in memory.
type Drawn = Result<(), Box<dyn std::error::Error>>;

/// \[W\] Fig. 9: marker distances over the iterations.
pub fn convergence(report: &Report) -> String {
    let iterations = &report.iterations;
    let tolerance = vec![report.tolerance; iterations.len()];
    let largest = iterations.iter().map(|i| i.max_marker_distance).collect();
    let mean = iterations.iter().map(|i| i.mean_marker_distance).collect();
    let lines =
        [("tolerance", BEFORE, tolerance), ("largest", LARGEST, largest), ("mean", AFTER, mean)];
    curves(&lines, "marker distance")
}

/// \[W\] Fig. 9 too: the objective over the iterations. While the weight of the markers grows, the
/// objective grows with it.
pub fn objective(report: &Report) -> String {
    let values = report.iterations.iter().map(|i| i.objective).collect();
    curves(&[("objective", AFTER, values)], "objective")
}

/// Curves over the iterations with a logarithmic axis.
fn curves(lines: &[(&'static str, RGBColor, Vec<f64>)], y: &str) -> String {
    // Zero has no logarithm.
    let positive = |value: &f64| value.max(1e-12);
    let all = || lines.iter().flat_map(|line| &line.2).map(positive);
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
    let last = (lines[0].2.len().max(2) - 1) as f64;
    svg(|root| {
        let mut chart = ChartBuilder::on(root)
            .margin(8)
            .x_label_area_size(34)
            .y_label_area_size(52)
            .build_cartesian_2d(0.0..last, (low * 0.8..high.max(low * 2.0) * 1.2).log_scale())?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .x_desc("iteration")
            .y_desc(y)
            .x_label_formatter(&|x| format!("{x:.0}"))
            .y_labels(5)
            .y_label_formatter(&|y| short(*y))
            .light_line_style(WHITE)
            .draw()?;
        for &(label, colour, ref values) in lines {
            let points = values.iter().enumerate().map(|(i, value)| (i as f64, positive(value)));
            chart
                .draw_series(LineSeries::new(points, colour.stroke_width(2)))?
                .label(label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour));
        }
        if lines.len() > 1 {
            // Distances fall from the upper left: this corner is free.
            chart
                .configure_series_labels()
                .position(SeriesLabelPosition::UpperRight)
                .background_style(WHITE.mix(0.8))
                .draw()?;
        }
        Ok(())
    })
}

/// \[W\] Fig. 16: how many markers are how far off, before and after. The last bin holds all beyond.
pub fn marker_histogram(report: &Report) -> String {
    let distances = &report.marker_distances;
    let mut sorted = distances.before.clone();
    sorted.sort_by(f64::total_cmp);
    let reach = sorted.get(sorted.len() * 9 / 10).copied().unwrap_or(1.0);
    let width = (reach.max(report.tolerance) / BINS as f64).max(f64::MIN_POSITIVE);
    let count = |values: &[f64]| {
        let mut bins = vec![0; BINS];
        for value in values {
            bins[((value / width) as usize).min(BINS - 1)] += 1;
        }
        bins
    };
    let (before, after) = (count(&distances.before), count(&distances.after));
    bars(
        [&before, &after],
        width,
        ["distance to the surface", "markers"],
        SeriesLabelPosition::UpperRight,
    )
}

/// \[W\] Fig. 17: smallest dihedral angle of the tets, before and after.
pub fn dihedral_histogram(report: &Report) -> String {
    let angles = &report.min_dihedral_histogram;
    // No tet has a smallest angle above 70.5 degrees.
    let until = 8.min(angles.before.len());
    bars(
        [&angles.before[..until], &angles.after[..until]],
        10.0,
        ["smallest dihedral angle, degrees", "tets"],
        SeriesLabelPosition::UpperLeft,
    )
}

/// Two histograms side by side, with the axes' names and a free corner for the legend.
fn bars(
    [before, after]: [&[usize]; 2],
    width: f64,
    [x, y]: [&str; 2],
    legend: SeriesLabelPosition,
) -> String {
    let highest = before.iter().chain(after).copied().max().unwrap_or(1).max(1) as f64;
    svg(|root| {
        let mut chart = ChartBuilder::on(root)
            .margin(8)
            .x_label_area_size(34)
            .y_label_area_size(52)
            .build_cartesian_2d(0.0..width * before.len() as f64, 0.0..highest * 1.05)?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .x_desc(x)
            .y_desc(y)
            .x_label_formatter(&|x| short(*x))
            .y_label_formatter(&|y| format!("{y:.0}"))
            .light_line_style(WHITE)
            .draw()?;
        for (counts, colour, label, share) in
            [(before, BEFORE, "before", [0.05, 0.5]), (after, AFTER, "after", [0.5, 0.95])]
        {
            let rectangles = counts.iter().enumerate().map(|(bin, &count)| {
                let corner = |s: f64, h: f64| ((bin as f64 + s) * width, h);
                Rectangle::new(
                    [corner(share[0], 0.0), corner(share[1], count as f64)],
                    colour.filled(),
                )
            });
            chart.draw_series(rectangles)?.label(label).legend(move |(x, y)| {
                Rectangle::new([(x, y - 4), (x + 12, y + 4)], colour.filled())
            });
        }
        chart.configure_series_labels().position(legend).background_style(WHITE.mix(0.8)).draw()?;
        Ok(())
    })
}

fn svg(draw: impl FnOnce(&DrawingArea<SVGBackend, plotters::coord::Shift>) -> Drawn) -> String {
    let mut text = String::new();
    let drawn = {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        draw(&root).and_then(|()| Ok(root.present()?))
    };
    // A plot that cannot be drawn (all values alike, say) is left out, the report is still good.
    drawn.map_or_else(|e| format!("<p>no plot: {e}</p>"), |()| text)
}

/// A number for an axis.
fn short(value: f64) -> String {
    match value.abs() {
        v if v == 0.0 || (0.01..1e5).contains(&v) => {
            let text = format!("{value:.3}");
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        }
        _ => format!("{value:.0e}"),
    }
}
