// Draws the charts of a page with plotly.js. What is in a chart was written by reports/chart.cpp; here it gets its
// place, by the width that the page has, when it comes into sight or is to be printed.
(() => {
  "use strict";

  const FONT = { family: "system-ui, 'Helvetica Neue', Arial, sans-serif", size: 12.5, color: "#1a1a1a" };
  const LEFT = 74, RIGHT = 14, BOTTOM = 48;      // margins of a panel, for its tics and labels [px]
  const ROW = 20;                                // of a panel's title and of a row of its legend [px]
  const SAMPLE = 46;                             // of a line in the legend with the blanks around it [px]
  const MODE_BAR = 26, TITLE = 32;               // what stands above the panels [px]
  const NARROWEST = 320;                         // a panel; below, fewer stand beside each other [px]
  const PAPER = 680;                             // width of A4 between the margins of style.css [px]
  const GUIDE_ROW = 14;                          // of a guide's text [px]
  const coarse = matchMedia("(pointer: coarse)").matches;  // a finger moves the page, not the axes
  const CONFIG = {
    displaylogo: false,
    doubleClick: "reset",
    displayModeBar: coarse ? true : "hover",
    modeBarButtons: [["toImage"], ["zoom2d", "pan2d", "zoomIn2d", "zoomOut2d", "resetScale2d"]],
  };

  const pen = document.createElement("canvas").getContext("2d");
  const widthOf = (text, size) => {
    pen.font = `${size}px ${FONT.family}`;
    return pen.measureText(unescape(text)).width;
  };

  /** What stands on the page for a text with entities. */
  const scratch = document.createElement("textarea");
  function unescape(text) {
    scratch.innerHTML = text;
    return scratch.value;
  }

  /** The numbers of reports/chart_data.h; NaN where the line has a gap. */
  function unpack(values) {
    if (Array.isArray(values)) return values;
    const bytes = atob(values.u16), numbers = new Float64Array(bytes.length / 2);
    const step = (values.to - values.from) / 65534;
    for (let i = 0; i < numbers.length; ++i) {
      const n = bytes.charCodeAt(2 * i) + 256 * bytes.charCodeAt(2 * i + 1);
      const value = values.from + step * n;
      numbers[i] = n === 65535 ? NaN : values.log ? 10 ** value : value;
    }
    return numbers;
  }

  /** Sets "xaxis.title.text" or "annotations[3].x" in an object. */
  function assign(object, path, value) {
    const words = path.replace(/\[(\d+)\]/g, ".$1").split(".");
    const last = words.pop();
    let at = object;
    for (const word of words) at = at[word] ??= {};
    at[last] = value;
  }

  /** Columns of a legend that fit `room`, and how wide each of them is. */
  function tabulate(widths, room) {
    for (let columns = widths.length; columns > 1; --columns) {
      const each = [];
      widths.forEach((width, i) => (each[i % columns] = Math.max(each[i % columns] ?? 0, width)));
      if (each.reduce((sum, width) => sum + width, 0) <= room) return each;
    }
    return [Math.max(...widths, 0)];
  }

  class Chart {
    constructor(figure) {
      this.plot = figure.querySelector(".plot");
      this.id = figure.id;
      this.spec = JSON.parse(figure.querySelector("script").textContent);
      this.drawn = false;
      this.heads = this.spec.grid.panels.map((panel) => this.measureHead(panel));
      this.plot.style.height = this.place(this.width()).height + "px";
    }

    width() {
      return Math.max(this.plot.clientWidth, 240);
    }

    /** Widths of the title of a panel and of the entries of its legend [px]. */
    measureHead(panel) {
      const { data, layout } = this.spec;
      return {
        title: panel.title < 0 ? 0 : widthOf(layout.annotations[panel.title].text, 13) + 14,
        legend: panel.legend.map((trace) => SAMPLE + widthOf(data[trace].name, 12)),
      };
    }

    /** How tall a panel's title and legend are, and where the legend's columns stand, in a panel of this width. */
    arrangeHead(head, width) {
      if (head.legend.length === 0) return { height: head.title > 0 ? ROW : 0, columns: [], shared: false };
      const all = head.legend.reduce((sum, entry) => sum + entry, 0);
      if (head.title + all <= width) return { height: ROW, columns: head.legend, shared: true };
      const columns = tabulate(head.legend, width);
      const rows = Math.ceil(head.legend.length / columns.length);
      return { height: ROW * (rows + (head.title > 0 ? 1 : 0)), columns, shared: false };
    }

    /** The layout's entries that follow from the width, as Plotly.relayout takes them, and the height. */
    place(width) {
      const { columns: wanted, panel_height, panels, title } = this.spec.grid;
      const columns = Math.max(1, Math.min(wanted, Math.floor(width / NARROWEST)));
      const cell = width / columns, inner = cell - LEFT - RIGHT;
      const heads = this.heads.map((head) => this.arrangeHead(head, inner));
      const boxes = [];
      const bar_above_title = title && width < 2 * NARROWEST;
      let top = bar_above_title ? MODE_BAR + TITLE : title ? TITLE : MODE_BAR;
      for (let first = 0; first < panels.length; first += columns) {
        const row = heads.slice(first, first + columns);
        const head = Math.max(...row.map((one) => one.height));
        const height = panel_height + Math.max(0, head - ROW);
        row.forEach((one, i) => boxes.push({
          left: i * cell + LEFT, right: (i + 1) * cell - RIGHT,
          top: top + head + 6, bottom: top + height - BOTTOM, head: one,
        }));
        top += height;
      }
      const update = { width, height: top };
      if (title) update["title.pad.t"] = bar_above_title ? MODE_BAR + 8 : 8;
      panels.forEach((panel, p) => this.placePanel(panel, p, boxes[p], update));
      return { height: top, update };
    }

    placePanel(panel, p, box, update) {
      const across = (pixels) => pixels / update.width, up = (pixels) => 1 - pixels / update.height;
      update[`${panel.x}.domain`] = [across(box.left), across(box.right)];
      update[`${panel.y}.domain`] = [up(box.bottom), up(box.top)];
      const { [panel.x]: x, [panel.y]: y } = this.spec.layout;
      update[`${panel.x}.nticks`] = Math.max(3, Math.round((box.right - box.left) / (x.type === "log" ? 70 : 50)));
      update[`${panel.y}.nticks`] = Math.max(4, Math.round((box.bottom - box.top) / (y.type === "log" ? 36 : 20)));
      if (panel.title >= 0) {
        update[`annotations[${panel.title}].x`] = across(box.left);
        update[`annotations[${panel.title}].y`] = up(box.top - box.head.height + ROW - 3);
      }
      const { columns, shared } = box.head;
      const start = shared ? box.right - columns.reduce((sum, width) => sum + width, 0) : box.left;
      panel.legend.forEach((trace, i) => {
        const column = i % columns.length, row = Math.floor(i / columns.length);
        const rows = Math.ceil(panel.legend.length / columns.length);
        const legend = this.spec.data[trace].legend;
        update[`${legend}.x`] = across(start + columns.slice(0, column).reduce((sum, width) => sum + width, 0));
        update[`${legend}.y`] = up(box.top + 1 - ROW * (rows - 1 - row));
      });
      this.placeGuides(panel, box, update);
    }

    /** Texts of vertical guides that would meet stand below each other; at the right edge they end at their line. */
    placeGuides(panel, box, update) {
      const { annotations, [panel.x]: axis } = this.spec.layout;
      const [from, to] = axis.range;
      const ends = [];
      const texts = panel.guides.map((index) => {
        const at = box.left + (box.right - box.left) * (annotations[index].x - from) / (to - from);
        const width = widthOf(annotations[index].text, 11) + 8;
        const left = at + width > box.right && at - width > box.left;
        return { index, left, begin: left ? at - width : at, end: left ? at : at + width };
      });
      texts.sort((a, b) => a.begin - b.begin);
      for (const { index, left, begin, end } of texts) {
        let row = ends.findIndex((taken) => taken <= begin);
        if (row < 0) row = ends.length;
        ends[row] = end;
        update[`annotations[${index}].yshift`] = -GUIDE_ROW * row;
        update[`annotations[${index}].xanchor`] = left ? "right" : "left";
      }
    }

    layout(update) {
      const layout = structuredClone(this.spec.layout);
      const { title, panels } = this.spec.grid;
      Object.assign(layout, {
        font: FONT, paper_bgcolor: "#fff", plot_bgcolor: "#fff", showlegend: true,
        hovermode: "closest", hoverdistance: 24,
        margin: { l: 0, r: 0, t: 0, b: 0, autoexpand: false }, dragmode: coarse ? false : "zoom",
        modebar: { color: "#888", activecolor: "#1a1a1a", bgcolor: "rgba(255,255,255,0)" },
      });
      if (title) layout.title = { text: title, x: 0.5, xanchor: "center", y: 1, yanchor: "top", font: { size: 15 } };
      for (const panel of panels) for (const name of [panel.x, panel.y]) this.styleAxis(layout[name], name[0] === "y");
      for (const annotation of layout.annotations) annotation.showarrow = false;
      for (const panel of panels) if (panel.title >= 0) layout.annotations[panel.title].font = { size: 13 };
      for (const { legend } of this.spec.data) {
        if (legend === undefined) continue;
        layout[legend] = { xanchor: "left", yanchor: "bottom", font: { size: 12 }, itemwidth: 30, borderwidth: 0,
                           bgcolor: "rgba(255,255,255,0)", itemdoubleclick: false };
      }
      for (const [path, value] of Object.entries(update)) assign(layout, path, value);
      return layout;
    }

    styleAxis(axis, vertical) {
      const own = { ...axis };
      Object.assign(axis, {
        autorange: false, showline: true, linecolor: "#404040", linewidth: 1, ticks: "outside", ticklen: 4,
        tickcolor: "#404040", gridcolor: "#e4e4e4", zeroline: false, exponentformat: "power", minexponent: 4,
        tickangle: 0, tickfont: { size: own.type === "log" ? 11 : 12 }, ...own,
      });
      axis.title = { ...own.title, standoff: vertical ? 8 : 6, font: { size: 12.5 } };
    }

    /** @returns a promise of the chart drawn at this width. */
    async draw(width = this.width()) {
      const { height, update } = this.place(width);
      this.plot.style.height = height + "px";
      if (this.drawn) {
        if (this.drawnWidth === width) return;
        this.drawnWidth = width;
        await Plotly.relayout(this.plot, { ...update, ...this.equalRanges() });
        return;
      }
      this.drawn = true;
      this.drawnWidth = width;
      this.plot.replaceChildren();
      const data = this.spec.data.map(
        (trace) => ({ type: "scatter", ...trace, x: unpack(trace.x), y: unpack(trace.y) }));
      const layout = this.layout(update);
      const config = { ...CONFIG, toImageButtonOptions: { format: "svg", filename: this.id } };
      const done = Plotly.newPlot(this.plot, data, layout, config);
      this.home = Object.fromEntries(this.spec.grid.panels.map((panel) => [panel.x, this.range(panel.x)]));
      this.plot.on("plotly_relayout", (change) => links.follow(this, change));
      links.join(this);
      await done;
      this.plot.dataset.drawn = "yes";
    }

    /** Where scales are equal Plotly widens a range to fit each size, and never takes it back. */
    equalRanges() {
      const { panels } = this.spec.grid, layout = this.spec.layout, ranges = {};
      for (const { x, y } of panels.filter((panel) => layout[panel.y].scaleanchor))
        for (const axis of [x, y]) ranges[`${axis}.range`] = [...layout[axis].range];
      return ranges;
    }

    range(axis) {
      return [...this.plot._fullLayout[axis].range];
    }
  }

  const same = (a, b) => a[0] === b[0] && a[1] === b[1];

  /** Axes of several charts that zoom together (FigureAxis::link of reports/figure.h). */
  const links = {
    shown: {},  // word -> range; missing: each chart's own

    follow(source, change) {
      if (!Object.keys(change).some((key) => key.startsWith("xaxis"))) return;
      for (const [word, axes] of Object.entries(source.spec.links)) {
        const range = source.range(axes[0]);
        if (same(range, this.shown[word] ?? source.home[axes[0]])) continue;
        if (same(range, source.home[axes[0]])) delete this.shown[word];
        else this.shown[word] = range;
        for (const chart of charts) if (chart !== source && chart.drawn) this.join(chart, word);
      }
    },

    /** Brings a chart to what the others show. */
    join(chart, only) {
      const update = {};
      for (const [word, axes] of Object.entries(chart.spec.links)) {
        if (only !== undefined && word !== only) continue;
        for (const axis of axes) {
          const range = this.shown[word] ?? chart.home[axis];
          if (!same(range, chart.range(axis))) update[`${axis}.range`] = [...range];
        }
      }
      if (Object.keys(update).length > 0) Plotly.relayout(chart.plot, update);
    },
  };

  const charts = [...document.querySelectorAll("figure.chart")].map((figure) => new Chart(figure));
  const drawAll = (width) => Promise.all(charts.map((chart) => chart.draw(width)));

  // Those in sight, or nearly so, are drawn; the others wait, at the height that they will have.
  const sight = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      const chart = charts.find(({ plot }) => plot === target);
      chart.near = isIntersecting;
      if (chart.near && !printing) chart.draw();
    }
  }, { rootMargin: "400px" });
  for (const chart of charts) sight.observe(chart.plot);

  let waiting = 0, printing = false;
  const fit = () => {
    for (const chart of charts) {
      if (chart.near) chart.draw();
      else chart.plot.style.height = chart.place(chart.width()).height + "px";
    }
  };
  addEventListener("resize", () => {
    clearTimeout(waiting);
    waiting = setTimeout(() => printing || fit(), 120);
  });
  addEventListener("beforeprint", () => {
    printing = true;
    drawAll(PAPER);
  });
  addEventListener("afterprint", () => {
    printing = false;
    fit();
  });

  window.uiclink = { charts, drawAll: () => drawAll() };  // for tests
})();
