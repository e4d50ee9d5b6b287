#include <tenon/tests/systems/report/page_layout.h>
#include <tenon/tests/testing/temporary_path.h>

#include <utility>

namespace tenon::testing {

namespace {

/// Measures the page as it stands. `screenshot` is a PNG of the window in base64.
constexpr const char* kFindFaults = R"js((async (screenshot) => {
  const faults = [], root = document.documentElement;
  const all = (selector) => [...document.querySelectorAll(selector)].filter((node) => node.checkVisibility());
  const box = (node) => node.getBoundingClientRect();
  const called = (node) => {
    const tag = node.tagName.toLowerCase() + (node.id ? `#${node.id}` : node.classList.length ? `.${node.classList[0]}` : '');
    return `${tag} '${node.textContent.trim().slice(0, 40)}'`;
  };
  const fault = (node, what) => faults.push(`${called(node)} ${what}`);
  const textOf = (node) => {
    const range = document.createRange();
    range.selectNodeContents(node);
    return range.getBoundingClientRect();
  };

  if (root.scrollWidth > root.clientWidth)
    faults.push(`the page is ${root.scrollWidth} px wide, the window ${root.clientWidth}`);
  for (const node of all('h1, header p, .verdict, button, #figures tr, #figures th, #figures td, .card th, .card td'))
    if (node.scrollWidth > node.clientWidth && getComputedStyle(node).display !== 'inline') fault(node, 'is cut off');

  // The table of figures.
  for (const row of all('#figures tr')) {
    const texts = [...row.cells].filter((cell) => cell.textContent.trim()).map(textOf);
    for (let i = 1; i < texts.length; ++i)
      if (texts[i].left < texts[i - 1].right - 0.5) fault(row, 'has values on top of each other');
    const frame = box(row.closest('table').parentElement);
    if (!row.closest('.several') && texts.some((text) => text.left < frame.left - 1 || text.right > frame.right + 1))
      fault(row, 'leaves the table');
  }
  for (const frame of all('#figures.several > div')) {
    const name = frame.querySelector('tbody th'), heads = [...frame.querySelectorAll('thead th')];
    [frame.scrollLeft, frame.scrollTop] = [1e6, 1e6];
    if (Math.abs(box(name).left - box(frame).left) > 1) fault(name, 'does not stay when the table scrolls');
    if (Math.abs(box(heads[0]).top - box(frame).top) > 1) fault(heads[0], 'does not stay when the table scrolls');
    if (box(heads.at(-1)).right > box(frame).left + frame.clientWidth + 1) fault(heads.at(-1), 'cannot be scrolled to');
    [frame.scrollLeft, frame.scrollTop] = [0, 0];
  }

  // Panels.
  for (const parent of all('body, main, #side, .cards, #slices')) {
    const panels = [...parent.children].filter((node) => node.checkVisibility() && node.id !== 'splitter');
    const boxes = panels.map(box), across = parent.matches('main, .cards');
    boxes.forEach((a, i) => {
      if (a.width < 200 || a.height < 10 || (across && (a.width < window.innerWidth / 4 || a.height < 30)))
        fault(panels[i], `is ${Math.round(a.width)} x ${Math.round(a.height)} px`);
      if (a.left < -1 || a.right > root.clientWidth + 1) fault(panels[i], 'leaves the window');
      boxes.slice(0, i).forEach((b, j) => {
        if (Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1)
          fault(panels[i], `overlaps ${called(panels[j])}`);
      });
    });
    if (panels.length && Math.max(...boxes.map((b) => b.right)) < box(parent).right - parent.clientWidth * 0.02 - 20)
      fault(parent, 'is not filled');
  }

  // Elements that are drawn.
  const inside = (node, holder, slack) => {
    const a = box(node), b = box(holder);
    if (a.left < b.left - 2 || a.right > b.right + 2 || a.right < b.right - slack) fault(node, `does not fit into ${called(holder)}`);
  };
  for (const stage of all('#stage')) {
    inside(stage, stage.parentElement, 2);
    const a = box(stage);
    if (a.height < 200 || a.bottom > window.innerHeight) fault(stage, `is not in sight: ${a.height} px high`);
    for (const canvas of stage.querySelectorAll('canvas')) {
      inside(canvas, stage, 4);
      if (Math.abs(box(canvas).height - a.height) > 4) fault(canvas, 'does not fill the replay');
    }
  }
  for (const canvas of all('.plot .chart canvas')) inside(canvas, canvas.closest('.area'), Infinity);
  for (const canvas of all('#slices canvas')) inside(canvas, canvas.parentElement, 4);

  for (const drawing of all('.card svg')) {
    const frame = box(drawing), texts = [...drawing.querySelectorAll('text')].filter((text) => text.textContent);
    const boxes = texts.map(box);
    boxes.forEach((a, i) => {
      if (a.left < frame.left - 1 || a.right > frame.right + 1) fault(texts[i], 'leaves its drawing');
      if (texts[i].hasAttribute('transform')) return;
      boxes.slice(0, i).forEach((b, j) => {
        if (!texts[j].hasAttribute('transform') && Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 &&
            Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 4)
          fault(texts[i], `is written over ${called(texts[j])}`);
      });
    });
  }

  // The picture.
  const image = new Image();
  image.src = `data:image/png;base64,${screenshot}`;
  await image.decode();
  const canvas = document.createElement('canvas');
  [canvas.width, canvas.height] = [image.width, image.height];
  if (image.width !== window.innerWidth || image.height !== window.innerHeight)
    faults.push(`the screenshot has ${image.width} x ${image.height} px`);
  const context = canvas.getContext('2d', {willReadFrequently: true});
  context.drawImage(image, 0, 0);
  for (const node of all('header, #stage, #figures, #run-bar, .plot, .card')) {
    const a = box(node), height = Math.min(a.bottom, image.height) - a.top;
    if (height < 30) continue;  // below the window
    const pixels = new Uint32Array(context.getImageData(a.left, a.top, a.width, height).data.buffer);
    if (new Set(pixels).size < 8) fault(node, 'is blank');
  }
  return faults;
}))js";

}  // namespace

std::vector<std::string> LayoutFaults(Browser& browser) {
  std::vector<std::string> faults;
  for (const auto& [width, height] : {std::pair{1280, 800}, {1600, 900}}) {
    browser.Resize(width, height);
    browser.Evaluate(
        "scrollTo(0, 0), new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))");
    const nlohmann::json found = browser.Evaluate(kFindFaults + ("('" + browser.Screenshot() + "')"));
    for (const std::string fault : found) faults.push_back(std::to_string(width) + " px: " + fault);
  }
  return faults;
}

nlohmann::json UnnamedControls(Browser& browser) {
  return browser.Evaluate(
      "[...document.querySelectorAll('button, select, input, [tabindex]')].filter((n) => n.checkVisibility() "
      "&& "
      "!(n.ariaLabel || n.textContent.trim() || (n.labels && n.labels.length))).map((n) => n.outerHTML)");
}

nlohmann::json DataOf(const std::filesystem::path& file) {
  const std::string page = ReadText(file), open = R"(<script type="application/json" id="data">)";
  const std::size_t begin = page.find(open) + open.size();
  return nlohmann::json::parse(page.substr(begin, page.find("</script>", begin) - begin));
}

}  // namespace tenon::testing
