// Draws the charts of a page with uPlot from the JSON inside each `figure.chart`.
//
// A chart is a list of series over two axes. A series is a line, a set of boxes, a set of bars with a height
// in px, or the rows of a colour map. Each is a uPlot series with columns of its own (mode 2). So each can be
// switched off, and a curve need not be a function of x. Charts with the same horizontal axis share zoom and
// pointer.
"use strict";
(() => {
  const FONT = '12px system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif';
  const SHADES = 8;
  // Dashes that distinguish solid lines in grey too.
  const DASHES = [[], [14, 4], [5, 3], [14, 3, 3, 3], [8, 3, 2, 3, 2, 3], [22, 5], [3, 2], [10, 2, 2, 2]];
  const DECLARED = { dashed: [7, 5], dotted: [2, 4] };
  const groups = new Map();

  const colour = (tone) =>
    getComputedStyle(document.documentElement).getPropertyValue("--" + tone).trim();
  const element = (name, parent, properties) =>
    parent.appendChild(Object.assign(document.createElement(name), properties));

  // A column is an array, or differences in units of 10^-d; null is a gap.
  const column = (packed) => {
    if (Array.isArray(packed)) return packed;
    const unit = 10 ** packed.d;
    let sum = 0;
    return packed.v.map((step) => (step === null ? null : (sum += step) / unit));
  };

  const number = (value, decimals) => {
    const text = Math.abs(value).toFixed(decimals);
    return (value < 0 && Number(text) !== 0 ? "\u2212" : "") + text;
  };
  const duration = (us, digits) => {
    const [value, unit] = us < 0.999 ? [us * 1e3, "ns"] : us < 999 ? [us, "µs"]
      : us < 999e3 ? [us / 1e3, "ms"] : [us / 1e6, "s"];
    return Number(value.toPrecision(digits)) + " " + unit;
  };
  const percent = (share) => Number((share * 100).toFixed(4)) + " %";
  // Decimals that write multiples of a step in full.
  const decimals = (step) => {
    let count = 0;
    while (count < 6 && Math.abs(Math.round(step * 10 ** count) / 10 ** count - step) > 1e-3 * step) count += 1;
    return count;
  };

  // The value under the pointer as text.
  const told = (axis, value) => {
    if (value === null || value === undefined) return "–";
    if (axis.format === "duration") return duration(value, 3);
    if (axis.format === "percent") return percent(value);
    if (axis.scale === "log") return String(Number(value.toPrecision(4)));
    return number(value, Math.max(Math.ceil(3 - Math.log10(axis.high - axis.low)), 0));
  };

  // The scale of an axis. Each nine of a distribution takes the same room.
  const scale = (axis, reversed) => {
    const common = { time: false, auto: false, range: [axis.low, axis.high], dir: reversed ? -1 : 1 };
    if (axis.scale === "log") return { ...common, distr: 3 };
    if (axis.scale !== "percentile") return common;
    const least = 10 ** -axis.nines;
    return {
      ...common, distr: 100, range: [0, 1 - least],
      fwd: (share) => -Math.log10(Math.max(1 - share, least)) / axis.nines,
      inv: (place) => 1 - 10 ** (-place * axis.nines),
    };
  };

  // The ticks of an axis in uPlot's form.
  const ticks = (key, axis, size) => {
    const line = (tone) => ({ stroke: () => colour(tone), width: 1 });
    const values = (u, splits, index, space, step) => splits.map((value) =>
      value === null ? "" : axis.format === "duration" ? duration(value, 1)
        : axis.format === "percent" ? percent(value)
        : axis.scale === "log" ? String(Number(value.toPrecision(2)).valueOf()).replace("-", "\u2212")
        : number(value, decimals(step)));
    const own = {
      scale: key, size, values, font: FONT, stroke: () => colour("quiet"),
      grid: line("grid"), ticks: { ...line("quiet"), size: 4 }, gap: 4,
    };
    if (key === "x") Object.assign(own, { space: 62, label: axis.label, labelFont: FONT, labelSize: 18, labelGap: 0 });
    else own.space = 26;
    if (axis.format === "count") own.incrs = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1e3, 2e3, 5e3, 1e4, 1e5, 1e6];
    if (axis.scale === "percentile") {
      const tail = Array.from({ length: axis.nines }, (_, nine) => 1 - 10 ** -(nine + 1));
      own.splits = () => [0, 0.5, ...tail];
      own.filter = (u, splits) => splits;
    }
    if (axis.rows) {
      const line = (row) => axis.high - 1 - row + axis.row_line;
      own.splits = () => (axis.row_line === undefined ? [] : axis.rows.map((_, row) => line(row)));
      own.values = (u, splits) => splits.map(() => "");
      own.ticks = { show: false };
    }
    return own;
  };

  const place = (u, x, y) => [u.valToPos(x, "x", true), u.valToPos(y, "y", true)];
  const path = (stroke, fill) => ({ stroke, fill, clip: null, band: null, gaps: null, flags: 0 });

  const linePath = (series) => (u, own) => {
    const drawn = new Path2D(), [xs, ys] = u.data[own];
    let before = null;
    xs.forEach((x, index) => {
      const y = ys[index];
      if (y === null || x === null) { before = null; return; }
      const at = place(u, x, y);
      if (before === null) drawn.moveTo(...at);
      else if (series.steps) drawn.lineTo(at[0], before);
      // A single point is a dot: round caps draw a segment without length.
      drawn.lineTo(...at);
      before = at[1];
    });
    return path(drawn, null);
  };

  // Points of a scatter: squares, diamonds or circles, so that kinds differ in grey too.
  const pointPath = (series) => (u) => {
    const drawn = new Path2D(), half = (series.shape === 0 ? 4.5 : 3.5) * uPlot.pxRatio;
    series.x.forEach((value, index) => {
      const [x, y] = place(u, value, series.y[index]);
      if (series.shape === 0) drawn.rect(x - half, y - half, 2 * half, 2 * half);
      if (series.shape === 1) {
        drawn.moveTo(x, y - 1.3 * half);
        for (const [across, down] of [[1.3, 0], [0, 1.3], [-1.3, 0]]) drawn.lineTo(x + across * half, y + down * half);
        drawn.closePath();
      }
      if (series.shape === 2) { drawn.moveTo(x + half, y); drawn.arc(x, y, half, 0, 7); }
    });
    return path(null, drawn);
  };

  // Boxes between two corners; a box without width is still visible.
  const boxPath = (series) => (u) => {
    const drawn = new Path2D();
    series.x.forEach((from, index) => {
      const [left, bottom] = place(u, from, series.y[index]);
      const [right, top] = place(u, series.x2[index], series.y2[index]);
      drawn.rect(left, top, Math.max(right - left, 1), bottom - top);
    });
    return path(drawn, drawn);
  };

  // Bars of a height in px around a value.
  const barPath = (series) => (u) => {
    const drawn = new Path2D(), half = series.px * uPlot.pxRatio / 2;
    series.x.forEach((from, index) => {
      const [left, y] = place(u, from, series.y[index]);
      drawn.rect(left, y - half, u.valToPos(series.x2[index], "x", true) - left, 2 * half);
    });
    return path(null, drawn);
  };

  // Rows of one shade of a map; each value holds until the next one.
  const shade = (map, value) =>
    Math.min(Math.max(Math.floor((value - map.low) / (map.high - map.low) * SHADES), 0), SHADES - 1);
  const shadePath = (map, step) => (u) => {
    const drawn = new Path2D();
    map.rows.forEach(({ x, y }, row) => {
      const top = Math.round(u.valToPos(row + 0.5, "y", true));
      const height = Math.max(Math.round(u.valToPos(row + 1.5, "y", true)) - top, 1);
      let from = null;
      x.forEach((at, index) => {
        const inside = shade(map, y[index]) === step && index + 1 < x.length;
        if (inside && from === null) from = at;
        if (!inside && from !== null) {
          const left = u.valToPos(from, "x", true);
          drawn.rect(left, top, u.valToPos(at, "x", true) - left + 0.5, height);
          from = null;
        }
      });
    });
    return path(null, drawn);
  };

  // A striped fill, so that kinds of boxes differ in grey too; the first is plain.
  const hatched = (tone, kind) => {
    const base = colour(tone);
    if (kind === 0) return base;
    const size = 8 * uPlot.pxRatio, tile = document.createElement("canvas");
    tile.width = tile.height = size;
    const ctx = tile.getContext("2d");
    ctx.globalAlpha = 0.5;
    ctx.fillStyle = ctx.strokeStyle = base;
    ctx.fillRect(0, 0, size, size);
    ctx.globalAlpha = 1;
    ctx.lineWidth = size / 4;
    ctx.beginPath();
    for (const shift of [-size, 0, size]) {
      if (kind % 3 === 1) { ctx.moveTo(shift, size); ctx.lineTo(shift + size, 0); }
      if (kind % 3 === 2) { ctx.moveTo(shift, 0); ctx.lineTo(shift + size, size); }
      if (kind % 3 === 0) { ctx.moveTo(0, size / 2); ctx.lineTo(size, size / 2); }
    }
    ctx.stroke();
    return ctx.createPattern(tile, "repeat");
  };

  // The background of a series in the legend: dashes and stripes as in the chart.
  const swatch = ({ tone, dash, stripes }) => {
    const base = `var(--${tone})`;
    if (stripes) return `repeating-linear-gradient(${["0deg", "135deg", "45deg"][stripes % 3]}, ${base} 0 2px, transparent 2px 5px)`;
    if (!dash || !dash.length) return base;
    let end = 0;
    const stops = dash.map((length, index) => `${index % 2 ? "transparent" : base} ${end}px ${end += length}px`);
    return `repeating-linear-gradient(90deg, ${stops})`;
  };

  // The point of a line under the pointer: by x, or the nearest one where x turns back.
  const sample = (u, own, series) => {
    const [x, y] = u.data[own], at = u.posToVal(u.cursor.left, "x");
    if (series.turns) {
      let best = null, least = 30 ** 2;
      x.forEach((value, index) => {
        if (y[index] === null) return;
        const across = u.valToPos(value, "x") - u.cursor.left, up = u.valToPos(y[index], "y") - u.cursor.top;
        if (across ** 2 + up ** 2 < least) { least = across ** 2 + up ** 2; best = { x: value, y: y[index] }; }
      });
      return best;
    }
    let low = 0, high = x.length - 1;
    if (high < 0 || at < x[low] || at > x[high]) return null;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (x[middle] <= at) low = middle; else high = middle;
    }
    if (y[low] === null || (y[high] === null && !series.steps)) return null;
    const share = series.steps || x[high] === x[low] ? 0 : (at - x[low]) / (x[high] - x[low]);
    return { x: at, y: y[low] + share * (y[high] - y[low]) };
  };

  // Text about boxes and rows under the pointer.
  const under = (u, chart) => {
    const x = u.posToVal(u.cursor.left, "x"), y = u.posToVal(u.cursor.top, "y");
    const here = (from, to) => `${told(chart.x, from)} to ${told(chart.x, to)}`;
    const parts = [];
    for (const [index, series] of chart.series.entries()) {
      if (!u.series[index + 1].show) continue;
      if (series.kind === "box") series.x.forEach((from, box) => {
        const inside = x >= from && x <= series.x2[box];
        if (!inside) return;
        if (chart.y.rows) parts.push([series.y[box], `${chart.y.rows[Math.round(chart.y.high - series.y2[box] - 0.3)]}: ${series.label}, ${here(from, series.x2[box])}`]);
        else if (y >= series.y[box] && y <= series.y2[box])
          parts.push([0, `${series.label}: ${here(from, series.x2[box])}, ${told(chart.y, series.y[box])} to ${told(chart.y, series.y2[box])}`]);
      });
      if (series.kind === "point") series.x.forEach((value, point) => {
        if (Math.hypot(u.valToPos(value, "x") - u.cursor.left, u.valToPos(series.y[point], "y") - u.cursor.top) < 7)
          parts.push([0, `${series.label}: ${told(chart.x, value)}, ${told(chart.y, series.y[point])}`]);
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
    for (const point of chart.points)
      if (Math.hypot(u.valToPos(point.x, "x") - u.cursor.left, u.valToPos(point.y, "y") - u.cursor.top) < 12)
        parts.push([0, point.label]);
    return parts.sort((a, b) => b[0] - a[0]).map((part) => part[1]);
  };

  const pointer = (u, chart, output, dots) => {
    const inside = u.cursor.left >= 0;
    const parts = inside ? [`${chart.x.label}: ${told(chart.x, u.posToVal(u.cursor.left, "x"))}`, ...under(u, chart)] : [];
    output.textContent = parts.join(" · ");
    u.setLegend(null, false);
    dots.forEach((dot, index) => {
      const shown = dot && inside && u.series[index + 1].show && sample(u, index + 1, chart.series[index]);
      if (dot) dot.hidden = !shown;
      if (shown) dot.style.transform = `translate(${u.valToPos(shown.x, "x")}px, ${u.valToPos(shown.y, "y")}px)`;
    });
  };

  // Texts, marks and points on top of the series.
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
    for (const [at, label, tone] of chart.marks) {
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
    for (const { x, y, label } of chart.points) {
      const [across, up] = place(u, x, y);
      ctx.beginPath();
      ctx.arc(across, up, 4 * ratio, 0, 7);
      ctx.fillStyle = colour("card"); ctx.fill();
      ctx.strokeStyle = colour("text"); ctx.lineWidth = 2 * ratio; ctx.stroke();
      const left = across > bbox.left + bbox.width * 0.7;
      if (chart.points.length <= 12) write(label, across + (left ? -8 : 8) * ratio, up + 4 * ratio, left ? "right" : "left", "text", true);
    }
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
        value: (u, _, own, index) => series.repeated ? "" : told(chart.y, index === null ? null : sample(u, own, series)?.y) };
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
