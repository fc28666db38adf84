// Parts of a chart that are functions of its data: columns, texts, scales, ticks, shapes and fills.
"use strict";
const timegapShapes = (() => {
  const FONT = '12px system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif';
  const SHADES = 8;
  // Dashes that distinguish solid lines in grey too.
  const DASHES = [[], [14, 4], [5, 3], [14, 3, 3, 3], [8, 3, 2, 3, 2, 3], [22, 5], [3, 2], [10, 2, 2, 2]];
  const DECLARED = { dashed: [7, 5], dotted: [2, 4] };

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
  const valueText = (axis, value) => {
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

  return {
    FONT, SHADES, DASHES, DECLARED, colour, element, column, number, valueText, scale, ticks, place,
    linePath, pointPath, boxPath, barPath, shadePath, hatched, swatch, sample,
  };
})();
