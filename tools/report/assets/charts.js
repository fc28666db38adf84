// Draws the charts of a page with uPlot from the JSON inside each `figure.chart`. `shapes.js` stands before this script.
//
// A chart is a list of series over two axes. A series is a line, a set of boxes, a set of bars with a height
// in px, or the rows of a colour map. Each is a uPlot series with columns of its own (mode 2). So each can be
// switched off, and a curve need not be a function of x. Charts with the same horizontal axis share zoom and
// pointer.
"use strict";
(() => {
  const {
    FONT, SHADES, DASHES, DECLARED, colour, element, column, number, valueText, scale, ticks, place,
    linePath, pointPath, boxPath, barPath, shadePath, hatched, swatch, sample,
  } = timegapShapes;
  const groups = new Map();

  // Text about boxes and rows under the pointer.
  const under = (u, chart) => {
    const x = u.posToVal(u.cursor.left, "x"), y = u.posToVal(u.cursor.top, "y");
    const here = (from, to) => `${valueText(chart.x, from)} to ${valueText(chart.x, to)}`;
    const parts = [];
    for (const [index, series] of chart.series.entries()) {
      if (!u.series[index + 1].show) continue;
      if (series.kind === "box") series.x.forEach((from, box) => {
        const inside = x >= from && x <= series.x2[box];
        if (!inside) return;
        if (chart.y.rows) parts.push([series.y[box], `${chart.y.rows[Math.round(chart.y.high - series.y2[box] - 0.3)]}: ${series.label}, ${here(from, series.x2[box])}`]);
        else if (y >= series.y[box] && y <= series.y2[box])
          parts.push([0, `${series.label}: ${here(from, series.x2[box])}, ${valueText(chart.y, series.y[box])} to ${valueText(chart.y, series.y2[box])}`]);
      });
      if (series.kind === "point") series.x.forEach((value, point) => {
        if (Math.hypot(u.valToPos(value, "x") - u.cursor.left, u.valToPos(series.y[point], "y") - u.cursor.top) < 7)
          parts.push([0, `${series.label}: ${valueText(chart.x, value)}, ${valueText(chart.y, series.y[point])}`]);
      });
      if (series.kind === "bar") series.x.forEach((from, bar) => {
        if (x >= from && x <= series.x2[bar] && Math.abs(u.valToPos(series.y[bar], "y") - u.cursor.top) < 12)
          parts.push([0, `${series.label}, ${here(from, series.x2[bar])}`]);
      });
    }
    if (chart.map) {
      const row = chart.map.rows[Math.round(y) - 1];
      const index = row && row.x.findLastIndex((from) => from <= x);
      if (row && index >= 0) parts.push([0, `${chart.y.label} ${Math.round(y)}: ${row.y[index]} ${chart.map.unit}`]);
    }
    return parts.sort((a, b) => b[0] - a[0]).map((part) => part[1]);
  };

  const pointer = (u, chart, output, dots) => {
    const inside = u.cursor.left >= 0;
    const parts = inside ? [`${chart.x.label}: ${valueText(chart.x, u.posToVal(u.cursor.left, "x"))}`, ...under(u, chart)] : [];
    output.textContent = parts.join(" · ");
    u.setLegend(null, false);
    dots.forEach((dot, index) => {
      const shown = dot && inside && u.series[index + 1].show && sample(u, index + 1, chart.series[index]);
      if (dot) dot.hidden = !shown;
      if (shown) dot.style.transform = `translate(${u.valToPos(shown.x, "x")}px, ${u.valToPos(shown.y, "y")}px)`;
    });
  };

  // Texts and marks on top of the series.
  const over = (u, chart) => {
    const { ctx, bbox } = u, ratio = uPlot.pxRatio;
    const write = (text, x, y, align, tone, halo) => {
      ctx.textAlign = align;
      if (halo) { ctx.strokeStyle = colour("card"); ctx.lineWidth = 3 * ratio; ctx.strokeText(text, x, y); }
      ctx.fillStyle = colour(tone);
      ctx.fillText(text, x, y);
    };
    ctx.save();
    ctx.font = FONT.replace("12px", 12 * ratio + "px");
    ctx.textBaseline = "alphabetic";
    ctx.setLineDash([]);
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left - 9 * ratio, 0, bbox.width + 18 * ratio, ctx.canvas.height);
    ctx.clip();
    let free = -Infinity;
    for (const [at, label, tone] of [...chart.marks].sort((a, b) => a[0] - b[0])) {
      const x = u.valToPos(at, "x", true);
      ctx.strokeStyle = colour(tone); ctx.lineWidth = 1.2 * ratio;
      ctx.setLineDash([3 * ratio, 3 * ratio]);
      ctx.beginPath(); ctx.moveTo(x, bbox.top); ctx.lineTo(x, bbox.top + bbox.height); ctx.stroke();
      ctx.setLineDash([]);
      // Close labels are placed beside each other.
      const middle = Math.max(x, free);
      free = middle + 17 * ratio;
      ctx.fillStyle = colour(tone);
      ctx.beginPath(); ctx.arc(middle, 10 * ratio, 8 * ratio, 0, 7); ctx.fill();
      write(String(label), middle, 14 * ratio, "center", "card");
    }
    ctx.restore();
    if (!chart.y.rows) write(chart.y.label, 4 * ratio, 13 * ratio, "left", "quiet");
    (chart.y.rows || []).forEach((name, row) =>
      write(name, bbox.left, u.valToPos(chart.y.high - row - 0.36, "y", true), "left", "text", true));
    for (const { y, label } of chart.texts)
      write(label, bbox.left + 4 * ratio, u.valToPos(y, "y", true) - 7 * ratio, "left", "text", true);
    ctx.beginPath();
    ctx.rect(bbox.left, 0, bbox.width, u.ctx.canvas.height);
    ctx.clip();
    if (chart.y.rows) for (const [index, series] of chart.series.entries()) series.x.forEach((from, box) => {
      const [left, bottom] = place(u, from, series.y[box]);
      const begin = Math.max(left, bbox.left), end = Math.min(u.valToPos(series.x2[box], "x", true), bbox.left + bbox.width);
      if (u.series[index + 1].show && ctx.measureText(series.label).width + 8 * ratio <= end - begin)
        write(series.label, begin + 5 * ratio, bottom - 6 * ratio, "left", "text", true);
    });
    ctx.restore();
  };

  // uPlot's options of each series in drawing order: wide lines lowest, then solid, then broken ones, so that
  // covered lines still show. The first series is on top.
  const seriesOf = (chart) => {
    const declared = [...chart.series].sort((a, b) => a.order - b.order);
    const solid = [...new Set(declared.filter((s) => s.stroke === "solid").map((s) => s.tone))];
    const boxes = declared.filter((s) => s.kind === "box");
    const scattered = declared.filter((s) => s.kind === "point");
    const facets = [{ scale: "x", auto: false }, { scale: "y", auto: false }];
    return chart.series.map((series) => {
      const common = { facets, label: series.label, points: { show: false }, value: () => "", width: 0, class: series.kind };
      if (series.kind === "box") {
        const kind = series.stripes = chart.y.rows ? boxes.indexOf(series) % 4 : boxes.indexOf(series);
        return { ...common, paths: boxPath(series), width: chart.y.rows ? 1 : 0, alpha: chart.y.rows ? 0.45 : 1,
          stroke: () => colour(series.tone), fill: () => hatched(series.tone, kind) };
      }
      if (series.kind === "point") {
        series.shape = scattered.indexOf(series) % 3;
        return { ...common, paths: pointPath(series), fill: () => colour(series.tone) };
      }
      if (series.kind === "bar") return { ...common, paths: barPath(series), fill: () => colour(series.tone) };
      if (series.kind === "shade") return { ...common, paths: shadePath(chart.map, series.step), fill: () => colour(series.tone) };
      // Lines over rows differ by their widths: there may be hundreds.
      const dash = series.dash = chart.y.rows ? [] : DECLARED[series.stroke] || DASHES[solid.indexOf(series.tone) % DASHES.length];
      return { ...common, paths: linePath(series), width: series.width, cap: dash.length ? "butt" : "round",
        dash: dash.map((length) => length * uPlot.pxRatio), stroke: () => colour(series.tone),
        value: (u, _, own, index) => series.repeated ? "" : valueText(chart.y, index === null ? null : sample(u, own, series)?.y) };
    });
  };

  const unpack = (chart) => {
    const { map } = chart;
    if (map) {
      map.rows = map.rows.map(([x, y]) => ({ x: column(x), y: column(y) }));
      const step = (map.high - map.low) / SHADES;
      chart.series = Array.from({ length: SHADES }, (_, index) => ({
        kind: "shade", order: index, tone: "q" + index, step: index, x: [map.low], y: [null],
        label: (index ? "" : "from ") + number(map.low + index * step, step < 1 ? 1 : 0) + (index ? "" : " " + map.unit),
      }));
      return chart;
    }
    // uPlot needs at least one series.
    if (!chart.series.length)
      chart.series.push({ kind: "line", label: "no data", tone: "muted", stroke: "solid", width: 1, x: [], y: [] });
    const rank = (series) => series.kind === "line" && series.stroke !== "solid";
    chart.series.forEach((series, index) => {
      series.order = index;
      for (const key of ["x", "y", "x2", "y2"]) if (series[key]) series[key] = column(series[key]);
      series.turns = series.kind === "line" && series.x.some((x, k) => k && x < series.x[k - 1]);
    });
    if (chart.y.rows) chart.series.sort((a, b) => b.order - a.order);
    else chart.series.sort((a, b) => rank(a) - rank(b) || (b.width || 0) - (a.width || 0) || b.order - a.order);
    return chart;
  };

  // Draws a chart into an element and returns uPlot's object. The axes of a `live` chart follow its data and
  // have no zoom.
  const draw = (mount, packed) => {
    const chart = unpack(packed), output = document.createElement("output");
    const whole = element("button", mount, { type: "button", className: "whole", textContent: "whole range", hidden: true });
    const key = JSON.stringify([chart.x.label, chart.x.low, chart.x.high]);
    const group = groups.get(key) || groups.set(key, []).get(key);
    const low = chart.x.low, high = chart.x.high;
    const zoomed = (u, name) => {
      if (name !== "x" || chart.live) return;
      const { min, max } = u.scales.x;
      whole.hidden = min === low && max === high;
      for (const other of group)
        if (other.scales.x.min !== min || other.scales.x.max !== max) other.setScale("x", { min, max });
    };
    const wide = mount.clientWidth >= 500;
    const linked = (type) => type === "mousemove" || type === "mouseleave";
    const dots = [];
    // Lines of equal appearance share one entry of the legend, without a value.
    const name = ({ label, tone, stroke }) => [label, tone, stroke].join();
    const repeats = (index) => chart.series.flatMap((other, at) => (name(other) === name(chart.series[index]) ? [at] : []));
    const hideRepeats = (u, own, { show }) => {
      if (own === null || show === undefined) return;
      for (const index of repeats(own - 1)) if (u.series[index + 1].show !== show) u.setSeries(index + 1, { show });
    };
    chart.series.forEach((series, index) => { series.repeated = repeats(index).length > 1; });
    const u = new uPlot({
      mode: 2, width: mount.clientWidth, height: chart.height + 70, padding: [24, chart.x.format === "duration" ? 22 : 14, 0, 0],
      scales: { x: scale(chart.x), y: scale(chart.y, Boolean(chart.map)) },
      axes: [ticks("x", chart.x, 24), ticks("y", chart.y, wide ? 60 : chart.y.format === "percent" ? 58 : 46)],
      series: [null, ...seriesOf(chart)],
      legend: {
        live: !chart.y.rows && chart.series.some((series) => series.kind === "line"),
        markers: { fill: (u, index) => swatch(chart.series[index - 1]) },
      },
      cursor: {
        y: false, drag: { x: !chart.live, y: false, dist: 4 },
        bind: chart.live ? { dblclick: () => null } : {},
        dataIdx: (u, own) => (chart.series[own - 1].kind === "line" && sample(u, own, chart.series[own - 1]) ? 0 : null),
        points: { show: false },
        sync: { key, scales: ["x", null], filters: { pub: linked, sub: linked } },
      },
      hooks: {
        setScale: [zoomed],
        setSeries: [hideRepeats],
        setCursor: [(u) => pointer(u, chart, output, dots)],
        draw: [(u) => over(u, chart)],
      },
    }, [null, ...chart.series.map((series) => [series.x, series.y])], mount);
    u.root.querySelectorAll(".u-series").forEach((row, index) => {
      row.style.order = chart.series[index].order;
      row.hidden = repeats(index)[0] !== index;
      if (chart.series[index].kind === "point") row.querySelector(".u-marker").classList.add("shape" + chart.series[index].shape);
      if (chart.series[index].px) row.querySelector(".u-marker").style.height = chart.series[index].px + "px";
    });
    whole.onclick = () => u.setScale("x", { min: low, max: high });
    dots.push(...chart.series.map((series) => {
      if (series.kind !== "line") return null;
      const dot = element("i", u.over, { className: "dot", hidden: true });
      dot.style.background = `var(--${series.tone})`;
      return dot;
    }));
    output.className = "pointer";
    u.root.append(output);
    touch(u.over);
    group.push(u);
    return u;
  };

  // A finger that moves sideways acts as a pointer; uPlot handles mice only.
  const touch = (over) => {
    over.style.touchAction = "pan-y";
    over.addEventListener("pointermove", (event) => {
      if (event.pointerType === "touch")
        over.dispatchEvent(new MouseEvent("mousemove", { clientX: event.clientX, clientY: event.clientY, bubbles: true }));
    });
  };

  const drawn = new Map();
  const fit = (mount) => {
    const width = mount.clientWidth, u = drawn.get(mount);
    if (!width) return;
    if (!u) drawn.set(mount, draw(mount, JSON.parse(mount.parentNode.querySelector("script").textContent)));
    else if (u.width !== width) u.setSize({ width, height: u.height });
  };
  // A mount also gets its width when its `details` opens.
  const sized = new ResizeObserver((entries) =>
    requestAnimationFrame(() => entries.forEach(({ target }) => fit(target))));
  const redraw = () => drawn.forEach((u) => u.redraw());
  document.querySelectorAll("figure.chart > .plot").forEach((mount) => sized.observe(mount));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  addEventListener("beforeprint", () => {
    document.documentElement.dataset.print = "";
    drawn.forEach((u) => u.setSize({ width: Math.min(u.width, 640), height: u.height }));
    redraw();
  });
  addEventListener("afterprint", () => {
    delete document.documentElement.dataset.print;
    drawn.forEach((u, mount) => u.setSize({ width: mount.clientWidth, height: u.height }));
    redraw();
  });
  window.timegap = { draw, drawn };
})();
