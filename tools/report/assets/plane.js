// Draws the bird's-eye view of a drive from the JSON inside each `figure.plane`: the whole way, and below it the
// surroundings of the ego at the instant that the slider chooses.
//
// All shapes are in metres of the plane. A transform of their group brings them to the screen, and strokes keep their
// width. Colours are names of the style sheet, so that a change of the theme needs no new drawing.
"use strict";
(() => {
  const SHADES = 8;
  // Share of the close-up that lies behind the ego's front bumper.
  const BEHIND = 0.25;
  const escape = (text) => text.replace(/[&<>"']/g, (sign) => `&#${sign.charCodeAt(0)};`);
  const number = (value, decimals) => value.toFixed(decimals).replace("-", "\u2212");
  const degrees = (angle) => angle * 180 / Math.PI;
  const line = (xs, ys) => xs.map((x, index) => `${index ? "L" : "M"}${x} ${ys[index]}`).join("");
  const path = (d, tone, width, more = "") =>
    `<path d="${d}" fill="none" stroke="var(--${tone})" stroke-width="${width}" vector-effect="non-scaling-stroke" stroke-linejoin="round" ${more}/>`;

  const surface = (road) => {
    const xs = [...road.left.x, ...road.right.x.toReversed()], ys = [...road.left.y, ...road.right.y.toReversed()];
    const edges = [road.left, road.right].map(({ x, y }) => path(line(x, y), "muted", 1.2)).join("");
    const marks = road.lines.map(({ x, y }) => path(line(x, y), "muted", 1, 'stroke-dasharray="6 6"')).join("");
    return `<path d="${line(xs, ys)}Z" fill="var(--grid)"/>${edges}${marks}`;
  };

  // The way in pieces of one shade each; a piece begins where the one before ends.
  const shaded = ({ x, y, speed }, low, high) => {
    const shade = (value) => Math.min(Math.max(Math.floor((value - low) / (high - low) * SHADES), 0), SHADES - 1);
    const pieces = [];
    for (let from = 0; from + 1 < x.length;) {
      let to = from + 1;
      while (to + 1 < x.length && shade(speed[to]) === shade(speed[from])) to += 1;
      pieces.push(path(line(x.slice(from, to + 1), y.slice(from, to + 1)), "q" + shade(speed[from]), 4));
      from = to;
    }
    return pieces.join("");
  };

  // Each kind is narrower than the one before, so that all show where they have the same span.
  const findings = (view) => view.findings.map(({ tone, spans }, kind) => spans.map(([from, to]) =>
    path(line(view.way.x.slice(from, to + 1), view.way.y.slice(from, to + 1)), tone, 18 - 4 * kind, 'stroke-linecap="round" opacity="0.8"')).join("")).join("");

  // The whole way, turned so that its ends lie beside each other.
  const whole = (view, width) => {
    const { x, y } = view.way, last = x.length - 1;
    const turn = Math.hypot(x[last] - x[0], y[last] - y[0]) < 1 ? 0 : -Math.atan2(y[last] - y[0], x[last] - x[0]);
    const [sine, cosine] = [Math.sin(turn), Math.cos(turn)];
    const across = [], up = [];
    for (const side of [view.road.left, view.road.right]) side.x.forEach((east, index) => {
      across.push(east * cosine - side.y[index] * sine);
      up.push(east * sine + side.y[index] * cosine);
    });
    const [left, right, bottom, top] = [Math.min(...across), Math.max(...across), Math.min(...up), Math.max(...up)];
    const most = Math.min(Math.max(0.6 * width, 160), 460), pad = 16;
    const scale = Math.min((width - 2 * pad) / (right - left), (most - 2 * pad) / Math.max(top - bottom, 1));
    const height = (top - bottom) * scale + 2 * pad + 22;
    const origin = [pad + ((width - 2 * pad) - (right - left) * scale) / 2 - left * scale, pad + top * scale];
    const turned = `translate(${origin}) scale(${scale} ${-scale}) rotate(${degrees(turn)})`;
    const step = [20, 50, 100, 200, 500, 1000, 2000, 5000].find((metres) => metres * scale > 50) || 10000;
    const bar = `<path d="M${pad} ${height - 8}h${step * scale}" stroke="var(--quiet)" stroke-width="2"/>
      <text x="${pad + step * scale + 6}" y="${height - 4}">${step} m</text>`;
    return `<svg width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" role="img" aria-label="The whole way">
      <g transform="${turned}">${surface(view.road)}${findings(view)}${path(line(x, y), "quiet", 6)}${shaded(view.way, view.low, view.high)}
      <g class="here"></g></g>${bar}</svg>`;
  };

  const rectangle = ([x, y, heading, length, width], tone, more = "") =>
    `<rect x="${-length / 2}" y="${-width / 2}" width="${length}" height="${width}" rx="0.4" fill="var(--${tone})" ${more}
      stroke="var(--card)" stroke-width="1" vector-effect="non-scaling-stroke" transform="translate(${x} ${y}) rotate(${degrees(heading)})"/>`;

  // The ego's body: its place is the middle of the front bumper.
  const own = ({ ego }, [x, y, heading]) => {
    const back = ego.length / 2;
    return rectangle([x - back * Math.cos(heading), y - back * Math.sin(heading), heading, ego.length, ego.width], "t0");
  };

  // The target: a line to its place, and a ring there.
  const aim = ([x, y], target) => target && path(`M${x} ${y}L${target[0]} ${target[1]}`, target[2], 2, 'stroke-dasharray="5 4"')
    + `<circle cx="${target[0]}" cy="${target[1]}" r="1.2" fill="none" stroke="var(--${target[2]})" stroke-width="2.5" vector-effect="non-scaling-stroke"/>`;

  const near = (view, index, width) => {
    const frame = view.frames[index], [x, y, heading] = frame.ego, height = width < 500 ? 170 : 210;
    const scale = width / (width < 500 ? 110 : 170);
    const place = `translate(${BEHIND * width} ${height / 2}) scale(${scale} ${-scale}) rotate(${-degrees(heading)}) translate(${-x} ${-y})`;
    const bodies = frame.bodies.map((body) => rectangle(body, body[5] ? "t1" : "t5")).join("");
    return `<svg width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" role="img" aria-label="${escape(frame.text)}">
      <g transform="${place}">${surface(view.road)}${path(line(view.way.x, view.way.y), "t0", 1, 'opacity="0.6"')}${bodies}${own(view, frame.ego)}${aim(frame.ego, frame.target) || ""}</g></svg>`;
  };

  const key = (mark, text) => `<span>${mark}${escape(text)}</span>`;
  const keys = (view) => {
    const step = (view.high - view.low) / SHADES;
    const shades = Array.from({ length: SHADES }, (_, shade) =>
      `<i style="background: var(--q${shade})" title="from ${number(view.low + shade * step, 1)} m/s"></i>`).join("");
    const found = view.findings.map(({ tone, name, spans }) =>
      key(`<i style="background: var(--${tone}); opacity: 0.8"></i>`, `${name}: ${spans.length}`)).join("");
    const cars = [["t0", "ego"], ["t1", "in the lane"], ["t5", "beside it"]]
      .map(([tone, name]) => key(`<i style="background: var(--${tone})"></i>`, name)).join("");
    return `<p class="keys"><span>${number(view.low, 1)} ${shades} ${number(view.high, 1)} m/s</span>${found}${cars}</p>`;
  };

  const draw = (mount, view) => {
    const slider = Object.assign(document.createElement("input"), {
      type: "range", min: 0, max: view.frames.length - 1, value: view.worst, className: "instant" });
    slider.setAttribute("aria-label", "Instant of the close-up");
    const [upper, lower, words] = ["div", "div", "output"].map((name) => document.createElement(name));
    words.className = "pointer";
    const legend = document.createElement("div");
    legend.innerHTML = keys(view);
    mount.append(upper, legend, lower, slider, words);
    const show = () => {
      const frame = view.frames[slider.value];
      lower.innerHTML = near(view, Number(slider.value), mount.clientWidth);
      words.textContent = frame.text + (Number(slider.value) === view.worst ? ` · ${view.why}` : "");
      const [x, y] = frame.ego;
      upper.querySelector(".here").innerHTML = path(`M${x} ${y}h0`, "text", 16, 'stroke-linecap="round"') + path(`M${x} ${y}h0`, "t0", 11, 'stroke-linecap="round"');
    };
    const fit = () => {
      if (!mount.clientWidth) return;
      upper.innerHTML = whole(view, mount.clientWidth);
      show();
    };
    slider.oninput = show;
    new ResizeObserver(() => requestAnimationFrame(fit)).observe(mount);
  };

  window.timegap.near = near;
  document.querySelectorAll("figure.plane > .plot").forEach((mount) =>
    draw(mount, JSON.parse(mount.parentNode.querySelector("script").textContent)));
})();
