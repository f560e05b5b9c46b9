// What a reader does with the animation of a simulation's report; the value is a list of faults.
(async () => {
  const faults = [];
  const expect = (what, is) => is || faults.push(what);
  const rest = (ms) => new Promise((done) => setTimeout(done, ms));
  const [view] = window.wagonViews ?? [];
  if (!view) return ["there is no animation"];
  const number = (element, name) => Number(element.getAttribute(name));
  const box = view.corners[0].box, leftGuide = view.corners[0].guides[0];
  view.figure.scrollIntoView();

  // It plays, and stops.
  const before = view.at;
  view.button.click();
  await rest(400);
  view.button.click();
  const after = view.at;
  expect(`it does not play: frame ${before} to ${after}`, after > before + 2);
  await rest(100);
  expect("it does not stop", view.at === after);

  // The slider seeks; displacements are drawn as many times as large as it says.
  view.time.value = 100;
  view.time.dispatchEvent(new Event("input"));
  expect(`the slider leads to frame ${view.at}`, Math.abs(view.at - 100) < 1e-6);
  const place = (times) => {
    view.size.value = times;
    view.size.dispatchEvent(new Event("input"));
    return number(box, "y");
  };
  const one = place(1), ten = place(10), y = view.motions.front_y[100];
  expect(`the front box is drawn ${((ten - one) / 9 / y).toFixed(3)} times as far`, Math.abs(ten - one - 9 * y) < 1e-9);

  // A box is beyond its guide in every frame in which the run says that it touches, and in no other; the guide is lit
  // then. The run has a sample for each frame.
  let touched = 0;
  for (let i = 0; i < view.count; ++i) {
    view.seek(i);
    view.corners.forEach(({ box: one, guides }, corner) => {
      const inner = number(guides[0], "y1") - (number(one, "y") + number(one, "height"));
      const rounding = 6e-5 * view.magnified;  // of the motions in the page: four parts, the yaw at the arm of 5 m
      const says = Boolean(view.touches[i] >> (4 * corner) & 1);
      if (says) ++touched;
      expect(`frame ${i}, corner ${corner}: drawn beyond the guide, but not touched`, inner > -rounding || says);
      expect(`frame ${i}, corner ${corner}: touched, but drawn apart`, inner < rounding || !says);
      if (says) expect(`frame ${i}, corner ${corner}: not lit`, guides[0].classList.contains("touched"));
    });
  }
  expect("no guide is ever touched in this run", touched > 0);
  const colour = (element) => getComputedStyle(element).stroke;
  leftGuide.classList.remove("touched");
  await rest(300);
  expect(`a guide is ${colour(leftGuide)}`, colour(leftGuide) === "rgb(119, 119, 119)");
  return faults;
})();
