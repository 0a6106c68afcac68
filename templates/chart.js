"use strict";
// Zoom and read-out for figures with curves, and saving of figures: of the report and of the page of `hydrosysid view`.
const charts = (() => {
  const unpack = (p) => {
    let sum = 0;
    return p.d.map((d) => (d === null ? NaN : p.o + p.s * (sum += d)));
  };
  const pixel = (v) => String(Math.round(Math.max(-1e5, Math.min(1e5, v)) * 10) / 10);
  const numbers = (text) => text.split(" ").map(Number);
  const SVG = "http://www.w3.org/2000/svg";
  const draw = (parent, name, attributes, text) => {
    const element = document.createElementNS(SVG, name);
    for (const key in attributes) element.setAttribute(key, attributes[key]);
    if (text !== undefined) element.textContent = text;
    parent.append(element);
    return element;
  };

  // The same round ticks as the static figure.
  const ticks = (low, high, about, power) => {
    const raw = (high - low) / about, decade = 10 ** Math.floor(Math.log10(raw)), f = raw / decade;
    const step = (f < 1.5 ? 1 : f < 3.5 ? 2 : f < 7.5 ? 5 : 10) * decade;
    const decimals = Math.max(0, Math.min(12, power - Math.floor(Math.log10(step * 1.000001))));
    const list = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step && list.length < 40; k++) {
      const text = (k * step / 10 ** power).toFixed(decimals);
      list.push([k * step, text.replace("-", Number(text) ? "−" : "")]);
    }
    return list;
  };

  const reading = (v, range) => {
    const decimals = Math.ceil(2 - Math.log10(range || 1));
    if (Math.abs(v) >= 1e6 || decimals > 9) return v.toPrecision(5).replace("-", "−");
    return v.toFixed(Math.max(0, decimals)).replace("-", "−");
  };

  class Curves {
    constructor(figure, svg, data) {
      Object.assign(this, { figure, svg, data, drag: null });
      this.reset_button = figure.querySelector(".reset");
      this.panels = [...svg.querySelectorAll(".panel")].map((g, p) => {
        const [x, y, w, h] = numbers(g.dataset.box), [x0, x1, y0, y1] = numbers(g.dataset.range);
        return { g, x, y, w, h, x0, x1, y0, y1, power: numbers(g.dataset.power), data: data.panels[p] };
      });
      this.whole = this.panels.map((p) => ({ x0: p.x0, x1: p.x1, y0: p.y0, y1: p.y1, html: p.g.innerHTML }));
      this.below = svg.querySelector(".lx");
      this.below_html = this.below.innerHTML;
      svg.classList.add("zooms");
      svg.setAttribute("tabindex", "0");
      svg.addEventListener("wheel", (e) => this.wheel(e), { passive: false });
      svg.addEventListener("pointerdown", (e) => this.down(e));
      svg.addEventListener("pointermove", (e) => this.move(e));
      svg.addEventListener("pointerup", (e) => this.up(e));
      svg.addEventListener("pointercancel", () => this.leave());
      svg.addEventListener("pointerleave", () => this.leave());
      svg.addEventListener("dblclick", () => this.reset());
      svg.addEventListener("keydown", (e) => this.key(e));
      this.reset_button.addEventListener("click", () => this.reset());
    }

    at(event) {
      const box = this.svg.getBoundingClientRect(), view = this.svg.viewBox.baseVal;
      return [(event.clientX - box.left) * view.width / box.width, (event.clientY - box.top) * view.height / box.height];
    }
    value(x) {
      const p = this.panels[0];
      return p.x0 + Math.max(0, Math.min(1, (x - p.x) / p.w)) * (p.x1 - p.x0);
    }
    inside([x, y]) {
      return this.panels.some((p) => x >= p.x - 4 && x <= p.x + p.w + 4 && y >= p.y && y <= p.y + p.h);
    }

    wheel(event) {
      const at = this.at(event);
      if (!this.inside(at)) return;
      event.preventDefault();
      const p = this.panels[0], x = this.value(at[0]), f = Math.exp(Math.max(-60, Math.min(60, event.deltaY)) * 0.004);
      this.zoom(x - (x - p.x0) * f, x + (p.x1 - x) * f);
      this.read(at);
    }
    down(event) {
      const at = this.at(event);
      if (event.button !== 0 || event.pointerType === "touch" || !this.inside(at)) return;
      this.svg.setPointerCapture(event.pointerId);
      this.drag = at[0];
    }
    move(event) {
      const at = this.at(event);
      this.choice?.remove();
      if (this.drag !== null) {
        const p = this.panels[0], last = this.panels[this.panels.length - 1];
        const [a, b] = [this.drag, at[0]].map((x) => Math.max(p.x, Math.min(p.x + p.w, x))).sort((a, b) => a - b);
        this.choice = draw(this.svg, "rect", { class: "choice", x: a, y: p.y, width: b - a, height: last.y + last.h - p.y });
      }
      this.read(at);
    }
    up(event) {
      this.choice?.remove();
      const from = this.drag, to = this.at(event)[0];
      this.drag = null;
      if (from !== null && Math.abs(to - from) > 5) {
        const [a, b] = [this.value(from), this.value(to)].sort((a, b) => a - b);
        // whoever has another use for the stretch takes it
        const choice = new CustomEvent("stretch", { bubbles: true, cancelable: true, detail: { from: a, to: b } });
        if (this.figure.dispatchEvent(choice)) this.zoom(a, b);
      }
    }
    leave() {
      this.choice?.remove();
      this.cross?.remove();
      this.readout?.remove();
      this.drag = null;
    }
    key(event) {
      const p = this.panels[0], w = p.x1 - p.x0;
      const change = {
        "+": [0.15, -0.15], "=": [0.15, -0.15], "-": [-0.2, 0.2], ArrowLeft: [-0.1, -0.1], ArrowRight: [0.1, 0.1],
      }[event.key];
      if (event.key === "Escape" || event.key === "0") this.reset();
      else if (change) {
        event.preventDefault();
        this.zoom(p.x0 + change[0] * w, p.x1 + change[1] * w);
      }
    }

    zoom(x0, x1) {
      const whole = this.whole[0], most = whole.x1 - whole.x0;
      const width = Math.max(most * 1e-4, Math.min(most, x1 - x0));
      if (width >= most) return this.reset();
      x0 = Math.max(whole.x0, Math.min(whole.x1 - width, x0));
      x1 = x0 + width;
      for (const p of this.panels) {
        Object.assign(p, { x0, x1 }, this.height(p, x0, x1));
        this.redraw(p);
      }
      const p = this.panels[0], y = this.below.dataset.y;
      this.below.replaceChildren();
      for (const [v, text] of ticks(x0, x1, p.w < 450 ? 4 : 8, p.power[0])) {
        draw(this.below, "text", { class: "tick", x: pixel(this.px(p, v)), y, "text-anchor": "middle" }, text);
      }
      this.reset_button.hidden = false;
    }
    reset() {
      this.panels.forEach((p, k) => {
        const { html, ...range } = this.whole[k];
        Object.assign(p, range);
        p.g.innerHTML = html;
      });
      this.below.innerHTML = this.below_html;
      this.reset_button.hidden = true;
    }

    // Lowest and highest of what is visible, with the margin of the static figure; all when nothing is.
    height(p, x0, x1) {
      let low = p.data.floor === null ? Infinity : -p.data.floor, high = -low;
      for (const s of p.data.series) {
        s.x.forEach((x, k) => {
          if (x < x0 || x > x1) return;
          for (const v of [s.y[k], s.low?.[k], s.high?.[k]]) {
            if (v < low) low = v;
            if (v > high) high = v;
          }
        });
      }
      const k = this.panels.indexOf(p), whole = this.whole[k], least = (whole.y1 - whole.y0) * 1e-3;
      if (!(low <= high)) return { y0: whole.y0, y1: whole.y1 };
      const pad = Math.max(0.06 * (high - low), least);
      return { y0: low - pad, y1: high + pad };
    }
    px(p, v) { return p.x + (v - p.x0) / (p.x1 - p.x0) * p.w; }
    py(p, v) { return p.y + p.h - (v - p.y0) / (p.y1 - p.y0) * p.h; }

    redraw(p) {
      const X = (v) => pixel(this.px(p, v)), Y = (v) => pixel(this.py(p, v));
      const gx = p.g.querySelector(".gx"), gy = p.g.querySelector(".gy");
      gx.replaceChildren();
      gy.replaceChildren();
      for (const [v] of ticks(p.x0, p.x1, p.w < 450 ? 4 : 8, p.power[0])) {
        draw(gx, "line", { class: "grid", x1: X(v), x2: X(v), y1: p.y, y2: p.y + p.h });
      }
      for (const [v, text] of ticks(p.y0, p.y1, p.h > 150 ? 5 : 3, p.power[1])) {
        draw(gy, "line", { class: v === 0 ? "zero" : "grid", x1: p.x, x2: p.x + p.w, y1: Y(v), y2: Y(v) });
        draw(gy, "text", { class: "tick", x: p.x - 7, y: pixel(this.py(p, v) + 4), "text-anchor": "end" }, text);
      }
      const set = (selector, d) => p.g.querySelector(selector)?.setAttribute("d", d);
      const box = (a, b, c, d) => `M${a} ${c}H${b}V${d}H${a}z`;
      this.data.spans.forEach(([a, b], k) => set(`[data-span="${k}"]`, box(X(a), X(b), p.y, p.y + p.h)));
      if (p.data.floor !== null) set("[data-floor]", box(p.x, p.x + p.w, Y(p.data.floor), Y(-p.data.floor)));
      p.data.series.forEach((s, k) => {
        let d = "", up = true;
        s.x.forEach((x, n) => {
          if (!(Number.isFinite(x) && Number.isFinite(s.y[n]))) { up = true; return; }
          d += s.mark === "dots" ? `M${X(x)} ${Y(s.y[n])}h0` : `${up ? "M" : "L"}${X(x)} ${Y(s.y[n])}`;
          up = false;
        });
        set(`[data-k="${k}"]`, d);
        if (!s.low) return;
        const known = s.x.map((_, n) => n).filter((n) => Number.isFinite(s.x[n] + s.low[n] + s.high[n]));
        set(`[data-i="${k}"]`, s.mark === "dots"
          ? known.map((n) => `M${X(s.x[n])} ${Y(s.low[n])}V${Y(s.high[n])}`).join("")
          : "M" + known.map((n) => `${X(s.x[n])} ${Y(s.high[n])}`)
            .concat(known.reverse().map((n) => `${X(s.x[n])} ${Y(s.low[n])}`)).join("L") + "z");
      });
    }

    read(at) {
      this.cross?.remove();
      this.readout?.remove();
      if (!this.inside(at) || this.drag !== null) return;
      const first = this.panels[0], last = this.panels[this.panels.length - 1], x = this.value(at[0]);
      const line = Math.max(first.x, Math.min(first.x + first.w, at[0]));
      this.cross = draw(this.svg, "line", { class: "cross", x1: line, x2: line, y1: first.y, y2: last.y + last.h });
      const box = document.createElement("div");
      box.className = "readout";
      const row = (name, text, colour) => {
        const div = document.createElement("div"), bold = document.createElement("b");
        if (colour) {
          const dot = document.createElement("i");
          dot.style.background = colour;
          div.append(dot);
        }
        bold.textContent = text;
        div.append(name + " ", bold);
        box.append(div);
      };
      row(this.data.x.label, `${reading(x, first.x1 - first.x0)} ${this.data.x.unit}`);
      for (const p of this.panels) {
        p.data.series.forEach((s, k) => {
          let best = -1, gap = Infinity;
          s.x.forEach((v, n) => {
            if (Math.abs(v - x) < gap && Number.isFinite(s.y[n])) { gap = Math.abs(v - x); best = n; }
          });
          if (best < 0 || gap > 0.03 * (first.x1 - first.x0)) return;
          const colour = getComputedStyle(p.g.querySelector(`[data-k="${k}"]`)).stroke, range = p.y1 - p.y0;
          const spread = s.low ? ` [${reading(s.low[best], range)}, ${reading(s.high[best], range)}]` : "";
          const name = this.panels.length > 1 && p !== first ? p.data.label : s.name || p.data.label;
          row(name, `${reading(s.y[best], range)}${spread} ${p.data.unit}`, colour);
        });
      }
      const frame = this.figure.getBoundingClientRect(), svg = this.svg.getBoundingClientRect();
      const scale = svg.width / this.svg.viewBox.baseVal.width;
      this.figure.append(box);
      const left = svg.left - frame.left + line * scale;
      const right = left + 14 + box.offsetWidth > frame.width;
      box.style.left = `${Math.max(0, right ? left - 14 - box.offsetWidth : left + 14)}px`;
      box.style.top = `${svg.top - frame.top + first.y * scale + 8}px`;
      this.readout = box;
    }
  }

  const save = (figure) => {
    const svg = figure.querySelector(".wide svg").cloneNode(true);
    const title = figure.querySelector(".title").textContent, [, , w, h] = numbers(svg.getAttribute("viewBox"));
    svg.querySelectorAll(".cross,.choice").forEach((e) => e.remove());
    const size = { width: w + 32, height: h + 60 };
    svg.setAttribute("xmlns", SVG);
    svg.setAttribute("viewBox", `-16 -44 ${size.width} ${size.height}`);
    for (const key in size) svg.setAttribute(key, size[key]);
    const front = document.createElementNS(SVG, "g");
    draw(front, "style", {}, document.getElementById("figure-style").textContent);
    draw(front, "rect", { class: "sheet", x: -16, y: -44, ...size });
    draw(front, "text", { class: "title", x: 2, y: -20 }, title);
    svg.prepend(front);
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([svg.outerHTML], { type: "image/svg+xml" }));
    link.download = `${figure.id}.svg`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };

  // Gives the figures below `root` their zoom, read-out and saving.
  const adorn = (root) => {
    for (const figure of root.querySelectorAll(".chart-figure")) {
      const block = figure.querySelector('script[type="application/json"]');
      if (block) {
        const data = JSON.parse(block.textContent);
        for (const p of data.panels) {
          for (const s of p.series) for (const key of ["x", "y", "low", "high"]) if (s[key]) s[key] = unpack(s[key]);
        }
        for (const svg of figure.querySelectorAll("svg.chart")) new Curves(figure, svg, data);
      }
      figure.querySelector(".save").addEventListener("click", () => save(figure));
    }
  };

  return { adorn };
})();
