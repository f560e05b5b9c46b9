// The wagon seen from above, as it moves. What is drawn was written by vehicle/page/animation.cpp: places in metres, x
// ahead, y to the left; motions in steps of 1e-5 m and 1e-6 rad.
//
// Displacements are drawn `magnified` times as large, and so are the clearances of the guides and of the flanges. Boxes
// and guides are placed by the same linear formulas as in the equations of motion (CalcDeflection, vehicle/wagon.h),
// so that they meet in the drawing when, and only when, they meet in the run.
(() => {
  "use strict";

  const SVG = "http://www.w3.org/2000/svg";
  // Of guides and flanges without what they are in: their copies in the close views are elsewhere.
  const STYLE = `
    .wagon-view svg { display: block; width: 100%; height: auto; background: #fff; }
    .wagon-view .close { display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); gap: .6rem; }
    .wagon-view .close svg { border: 1px solid #ddd; }
    .wagon-view .bar { display: flex; flex-wrap: wrap; gap: .4rem 1.2rem; align-items: center; font-size: .9rem;
      margin: .4rem 0; }
    .wagon-view .bar label { display: flex; gap: .4rem; align-items: center; }
    .wagon-view .bar button { font: inherit; min-width: 5rem; padding: .2rem .6rem; }
    .wagon-view .time { width: 100%; margin: 0; }
    .wagon-view output { font-variant-numeric: tabular-nums; }
    .wagon-view .strip { height: 5rem; cursor: pointer; touch-action: none; }
    .wagon-guide { stroke: #777; stroke-width: .035; transition: stroke .15s, stroke-width .15s; }
    .wagon-guide.touched { stroke: #d55e00; stroke-width: .11; transition: none; }
    .wagon-flange { stroke: #333; stroke-width: .035; transition: stroke .15s, stroke-width .15s; }
    .wagon-flange.touched { stroke: #d55e00; stroke-width: .1; transition: none; }
    @media print {
      .wagon-view button, .wagon-view select, .wagon-view input, .wagon-view label,
      .wagon-view .close { display: none !important; }
    }`;
  const COLOURS = { front: "#0072b2", rear: "#d55e00", body: "#009e73" };  // as in the charts of the motions
  const BOX = { length: 0.36, width: 0.26 }, WHEEL = { length: 0.92, width: 0.13 }, SPRING = 1.3;
  const LARGEST = 60;     // magnification: a guide of 20 mm stands 1.2 m off
  const ROOM = 0.4;       // for a displacement or a clearance as it is drawn at first [m]
  const FLASH = 2;        // frames before and after one with contact that show it, too

  function add(parent, name, attributes = {}) {
    const element = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    parent.append(element);
    return element;
  }

  function make(name, attributes, ...children) {
    const element = Object.assign(document.createElement(name), attributes);
    element.append(...children);
    return element;
  }

  const line = (parent, x1, y1, x2, y2, attributes) => add(parent, "line", { x1, y1, x2, y2, ...attributes });
  const rectangle = (parent, x, y, length, width, attributes) =>
    add(parent, "rect", { x: x - length / 2, y: y - width / 2, width: length, height: width, ...attributes });
  const set = (element, attributes) => {
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  };

  class WagonView {
    constructor(figure) {
      const { wagon, hz, begin, frames, touches } = JSON.parse(figure.querySelector("script").textContent);
      Object.assign(this, { figure, wagon, hz, begin, touches });
      this.motions = {};
      for (const [name, steps] of Object.entries(frames)) {
        const unit = /psi|phi/.test(name) ? 1e-6 : 1e-5;
        this.motions[name] = steps.map((step) => step * unit);
      }
      this.count = touches.length;
      this.at = 0;         // frame, with its fraction
      this.playing = false;
      this.magnified = this.chooseMagnification();
      this.stage = figure.querySelector(".stage");
      this.drawScene();
      this.drawStrip();
      this.addControls();
      this.show();
    }

    /** So that displacements, and the clearances with them, have room on the drawing. */
    chooseMagnification() {
      const { wagon, motions } = this;
      const largest = (names) => Math.max(1e-9, ...names.flatMap((name) => motions[name].map(Math.abs)));
      const times = Math.min(ROOM / largest(["front_y", "rear_y", "body_y"]), ROOM / wagon.lateral,
                             ROOM / (wagon.length / 2 * largest(["body_psi"])) * 2);
      return Math.min(LARGEST, Math.max(5, 5 * Math.round(times / 5)));
    }

    // ---------------------------------------------------------------- what is drawn

    drawScene() {
      const { wagon } = this, half = wagon.length / 2 + 0.4, side = wagon.width / 2 + 0.75;
      const main = add(this.stage, "svg", { viewBox: `${-half} ${-side} ${2 * half} ${2 * side}` });
      this.scene = add(main, "g", { id: this.figure.id + "-scene", transform: "scale(1 -1)" });
      for (const y of [-wagon.rail, wagon.rail])
        rectangle(this.scene, 0, y, 2 * half, 0.07, { fill: "#b5b5b5" });
      line(this.scene, -half, 0, half, 0, { stroke: "#ccc", "stroke-width": 0.015, "stroke-dasharray": ".2 .15" });
      this.body = add(this.scene, "g");
      rectangle(this.body, -wagon.com, 0, wagon.length, wagon.width,
                { fill: COLOURS.body, "fill-opacity": 0.1, stroke: COLOURS.body, "stroke-width": 0.045 });
      line(this.body, -wagon.com - wagon.length / 2, 0, -wagon.com + wagon.length / 2, 0,
           { stroke: COLOURS.body, "stroke-width": 0.02 });
      this.axles = ["front", "rear"].map((name) => this.drawAxle(name));
      this.corners = wagon.corners.map((corner) => this.drawCorner(corner));
      const names = add(main, "g", { "font-size": 0.27, fill: "#444", "text-anchor": "middle" });
      add(names, "text", { x: half - 1.2, y: -side + 0.4 }).textContent = "ahead \u2192";
      add(names, "text", { x: 0, y: -side + 0.4 }).textContent = "left";
      this.drawCloseViews();
    }

    drawAxle(name) {
      const { wagon } = this, group = add(this.scene, "g");
      line(group, 0, -wagon.b, 0, wagon.b, { stroke: COLOURS[name], "stroke-width": 0.09 });
      for (const y of [-wagon.rail, wagon.rail])
        rectangle(group, 0, y, WHEEL.length, WHEEL.width, { fill: COLOURS[name], "fill-opacity": 0.75 });
      const visibility = wagon.flange ? "visible" : "hidden";
      const flanges = [1, -1].map(() => line(this.scene, 0, 0, 0, 0, { class: "wagon-flange", visibility }));
      return { name, group, flanges };
    }

    drawCorner({ axle }) {
      const spring = line(this.scene, 0, 0, 0, 0, { stroke: "#333", "stroke-width": 0.05 });
      const links = [1, -1].map(() => line(this.scene, 0, 0, 0, 0, { stroke: "#333", "stroke-width": 0.035 }));
      const brackets = [1, -1].map(() => add(this.scene, "circle", { r: 0.07, fill: COLOURS.body }));
      const box = rectangle(this.scene, 0, 0, BOX.length, BOX.width,
                            { fill: COLOURS[axle], stroke: "#222", "stroke-width": 0.02 });
      const guides = [0, 1, 2, 3].map(() => line(this.scene, 0, 0, 0, 0, { class: "wagon-guide" }));
      return { spring, links, brackets, box, guides };
    }

    /** Both wheelsets once more, nearer. */
    drawCloseViews() {
      const { wagon } = this, room = make("div", { className: "close" });
      for (const [name, x] of [["rear", -wagon.l], ["front", wagon.l]]) {
        const view = add(room, "svg", { viewBox: `${x - 1.9} -1.8 3.8 3.6` });
        add(view, "use", { href: "#" + this.scene.id });
        add(view, "text", { x: x - 1.8, y: -1.58, "font-size": 0.17, fill: "#444" }).textContent = name + " wheelset";
      }
      this.stage.append(room);
    }

    /** Lateral motions over time, and where something is touched. */
    drawStrip() {
      const viewBox = `0 -1.1 ${this.count - 1} 2.4`, thin = { "vector-effect": "non-scaling-stroke" };
      const strip = add(this.stage, "svg", { class: "strip", viewBox, preserveAspectRatio: "none" });
      const names = ["front", "rear", "body"];
      const largest = Math.max(1e-9, ...names.flatMap((name) => this.motions[name + "_y"].map(Math.abs)));
      line(strip, 0, 0, this.count - 1, 0, { stroke: "#ddd", ...thin });
      for (const name of names) {
        const points = this.motions[name + "_y"].map((y, i) => `${i},${(-y / largest).toFixed(4)}`).join(" ");
        add(strip, "polyline", { points, fill: "none", stroke: COLOURS[name], "stroke-width": 1.2, ...thin });
      }
      this.touches.forEach((bits, i) => {
        if (bits & 0xffff) line(strip, i, 1.15, i, 1.3, { stroke: COLOURS.rear, "stroke-width": 2, ...thin });
      });
      this.cursor = line(strip, 0, -1.1, 0, 1.3, { stroke: "#111", "stroke-width": 1.5, ...thin });
      const seek = (event) => {
        const box = strip.getBoundingClientRect();
        this.seek((event.clientX - box.left) / box.width * (this.count - 1));
      };
      strip.addEventListener("pointerdown", (event) => {
        strip.setPointerCapture(event.pointerId);
        seek(event);
      });
      strip.addEventListener("pointermove", (event) => event.buttons && seek(event));
    }

    addControls() {
      this.button = make("button", { type: "button", textContent: "Play", onclick: () => this.toggle() });
      this.time = make("input", { type: "range", className: "time", min: 0, max: this.count - 1, step: "any", value: 0,
                                  oninput: () => this.seek(Number(this.time.value)) });
      this.time.setAttribute("aria-label", "time");
      const rates = [1, 0.5, 0.25, 0.1];
      this.rate = make("select", {}, ...rates.map(
        (rate) => make("option", { value: rate, textContent: `${rate} \u00d7 real time` })));
      this.rate.value = "0.5";
      this.size = make("input", { type: "range", min: 1, max: LARGEST, step: 1, value: this.magnified,
                                  oninput: () => this.magnify(Number(this.size.value)) });
      this.sizeText = make("output", {});
      this.text = make("output", {});
      const bar = make("div", { className: "bar" }, this.button, make("label", {}, "speed", this.rate),
                       make("label", {}, "displacements", this.size, this.sizeText), this.text);
      this.stage.append(this.time, bar);
    }

    // ---------------------------------------------------------------- what moves

    motion(name) {
      const values = this.motions[name], i = Math.min(Math.floor(this.at), this.count - 2), part = this.at - i;
      return values[i] + part * (values[i + 1] - values[i]);
    }

    show() {
      const { wagon, magnified: M } = this;
      const body = { y: this.motion("body_y") + wagon.h * this.motion("body_phi"), psi: this.motion("body_psi") };
      this.body.setAttribute("transform", `matrix(1 ${M * body.psi} ${-M * body.psi} 1 ${wagon.com} ${M * body.y})`);
      const bits = this.touched();
      this.axles.forEach((axle, i) => this.showAxle(axle, i, M, bits));
      this.corners.forEach((corner, i) => this.showCorner(corner, i, M, body, bits));
      const now = Math.round(this.at);
      set(this.cursor, { x1: this.at, x2: this.at });
      this.time.value = this.at;
      this.sizeText.value = `\u00d7 ${M}`;
      const mm = (name) => (1e3 * this.motion(name)).toFixed(1).replace("-", "\u2212");
      this.text.value = `${(this.begin + now / this.hz).toFixed(2)} s: front ${mm("front_y")} mm, ` +
        `rear ${mm("rear_y")} mm, body ${mm("body_y")} mm to the left`;
    }

    /** What is touched now, or has just been. */
    touched() {
      const now = Math.round(this.at);
      let bits = 0;
      for (let i = Math.max(0, now - FLASH); i <= Math.min(this.count - 1, now + FLASH); ++i) bits |= this.touches[i];
      return bits;
    }

    showAxle({ name, group, flanges }, index, M, bits) {
      const { wagon } = this, X = index === 0 ? wagon.l : -wagon.l;
      const psi = this.motion(name + "_psi"), x = X + M * this.motion(name + "_x"), y = M * this.motion(name + "_y");
      group.setAttribute("transform", `matrix(1 ${M * psi} ${-M * psi} 1 ${x} ${y})`);
      [1, -1].forEach((e, side) => {  // it meets the inner edge of its rail as y is the play of the flange
        const at = e * (wagon.rail - 0.035 - M * wagon.flange) + y;
        set(flanges[side], { x1: x - WHEEL.length / 2 - 0.05, x2: x + WHEEL.length / 2 + 0.05, y1: at, y2: at });
        flanges[side].classList.toggle("touched", Boolean(bits >> (16 + 2 * index + side) & 1));
      });
    }

    showCorner({ spring, links, brackets, box, guides }, index, M, body, bits) {
      const { wagon } = this, { axle, side, X, Y } = wagon.corners[index];
      const place = axle === "front" ? wagon.l : -wagon.l;
      const x = place + M * (this.motion(axle + "_x") - side * wagon.b * this.motion(axle + "_psi"));
      const y = side * wagon.b + M * this.motion(axle + "_y");
      const gx = place - M * Y * body.psi, gy = side * wagon.b + M * (body.y + X * body.psi);
      set(box, { x: x - BOX.length / 2, y: y - BOX.width / 2 });
      set(spring, { x1: x - SPRING / 2, x2: x + SPRING / 2, y1: y, y2: y });
      [1, -1].forEach((e, i) => {
        set(brackets[i], { cx: gx + e * (SPRING / 2 + 0.25), cy: gy });
        set(links[i], { x1: x + e * SPRING / 2, y1: y, x2: gx + e * (SPRING / 2 + 0.25), y2: gy });
      });
      const along = BOX.length / 2 + M * wagon.longitudinal, across = BOX.width / 2 + M * wagon.lateral;
      const ends = [[-along, across, along, across], [-along, -across, along, -across],
                    [along, -across, along, across], [-along, -across, -along, across]];
      guides.forEach((guide, i) => {  // to the left, to the right, ahead, behind
        const [x1, y1, x2, y2] = ends[i];
        set(guide, { x1: gx + x1, y1: gy + y1, x2: gx + x2, y2: gy + y2,
                     visibility: wagon.guided ? "visible" : "hidden" });
        guide.classList.toggle("touched", Boolean(bits >> (4 * index + i) & 1));
      });
    }

    // ---------------------------------------------------------------- what a reader does

    seek(at) {
      this.at = Math.min(Math.max(at, 0), this.count - 1);
      this.show();
    }

    magnify(times) {
      this.magnified = times;
      this.show();
    }

    toggle() {
      this.playing = !this.playing;
      this.button.textContent = this.playing ? "Pause" : "Play";
      if (!this.playing) return;
      if (this.at >= this.count - 1) this.at = 0;
      let last;
      const step = (now) => {
        if (!this.playing) return;
        this.at += last === undefined ? 0 : (now - last) / 1e3 * this.hz * Number(this.rate.value);
        last = now;
        if (this.at >= this.count - 1) this.at = 0;  // over and over
        this.show();
        requestAnimationFrame(step);
      };
      requestAnimationFrame(step);
    }
  }

  document.head.append(make("style", { textContent: STYLE }));
  window.wagonViews = [...document.querySelectorAll("figure.wagon-view")].map((figure) => new WagonView(figure));
})();
