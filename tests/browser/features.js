// What a reader does with the page features.html of sample_pages.cpp; the value is a list of faults.
(async () => {
  const faults = [];
  const expect = (what, is) => is || faults.push(what);
  const near = (a, b) => Math.abs(a[0] - b[0]) < 1e-9 && Math.abs(a[1] - b[1]) < 1e-9;
  const [features, first, second] = uiclink.charts;
  const rest = () => new Promise((done) => setTimeout(done, 100));
  await uiclink.drawAll();

  // Axes of time zoom together, in one figure and in others; and come back together.
  const home = first.range("xaxis");
  await Plotly.relayout(first.plot, { "xaxis.range": [2, 4] });
  await rest();
  for (const chart of [first, second])
    for (const axis of ["xaxis", "xaxis2"])
      expect(`${chart.id}: ${axis} does not follow`, near(chart.range(axis), [2, 4]));
  expect("an axis without the link follows", !near(features.range("xaxis"), [2, 4]));
  await Plotly.relayout(second.plot, { "xaxis.range": [...home] });
  await rest();
  expect("axes do not come back", near(first.range("xaxis"), home) && near(second.range("xaxis2"), home));

  // A click in the legend hides a series, and that one only.
  const item = first.plot.querySelector(".legendtoggle");
  for (const type of ["mousedown", "mouseup"]) item.dispatchEvent(new MouseEvent(type, { bubbles: true }));
  await new Promise((done) => setTimeout(done, 600));  // Plotly waits for a second click
  const visible = first.plot._fullData.map((trace) => trace.visible);
  const others = visible.slice(1).every((one) => one === true);
  expect(`after a click in the legend: ${visible}`, visible[0] === "legendonly" && others);

  // Texts are texts.
  const text = features.plot.textContent;
  for (const words of ["</script><script>alert(1)</script>", "<b>no</b> tag & no %{x}", "<i>x</i> < y", "\"quoted\" 'text'"])
    expect(`not as it was written: ${words}`, text.includes(words));

  // A millimetre is as long on both axes; an axis runs backwards.
  const { xaxis3, yaxis3 } = features.plot._fullLayout;
  expect("scales are not equal", Math.abs(Math.abs(xaxis3._m) - Math.abs(yaxis3._m)) < 1e-6 * Math.abs(xaxis3._m));
  const [from, to] = features.range("xaxis4");
  expect("the axis is not reversed", from > to);

  // Guides are lines as long as their panel.
  const lines = [...features.plot.querySelectorAll(".shapelayer path")].map((path) => path.getBoundingClientRect());
  const long = lines.filter(({ width, height }) => Math.max(width, height) > 100).length;
  expect(`${long} of ${features.spec.layout.shapes.length} guides`, long === features.spec.layout.shapes.length);

  // Values under the pointer have units.
  const hover = features.plot._fullData.map((trace) => trace.hovertemplate);
  expect(`no units: ${hover[0]}`, hover[0].startsWith("%{x:.5~g} mm, %{y:.5~g} J"));
  return faults;
})();
