// Elements of the page: how they are made, and how a part of it is drawn anew without taking the keyboard's place away.

const byId = (id) => document.getElementById(id);

// An element with attributes and children; what is null is left out, and names that begin with `on` are listeners.
const element = (tag, attributes = {}, ...children) => {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name === "value") made.value = value;
    else if (name === "checked" || name === "disabled" || name === "selected" || name === "open") made[name] = value;
    else made.setAttribute(name, value);
  }
  made.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return made;
};

// Puts new children into a part of the page; what had the focus has it again.
const draw = (parent, ...children) => {
  const focused = parent.contains(document.activeElement) ? document.activeElement.id : "";
  parent.replaceChildren(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  if (focused) byId(focused)?.focus({ preventScroll: true });
};

// Figures come from the server as they stand in a report.
const drawFigures = (parent, figures) => {
  parent.innerHTML = figures.join("");
  charts.adorn(parent);
};

const SIGNS = { green: ["✓", "in order"], amber: ["!", "to be kept in mind"], red: ["✕", "not to be trusted"] };

// A light with its sign: colour alone tells nothing to many.
const light = (colour, what = "") => {
  const [sign, word] = SIGNS[colour] ?? ["–", "not judged"];
  const said = what ? `${what}: ${word}` : word;
  return element("span", { class: `light ${colour ?? "off"}`, role: "img", "aria-label": said, title: said }, sign);
};

const COLOURS = { error: "red", warning: "amber", note: "off" };

const finding = (f) => element("li", { class: COLOURS[f.severity] === "off" ? "note-line" : COLOURS[f.severity] },
  light(COLOURS[f.severity], f.severity), element("span", {}, marked(f.message), " ", element("code", {}, f.code)));

// Findings, the worst first; beyond a few the rest is folded away.
const findings = (list, shown = 4) => {
  if (!list.length) return null;
  const rank = { error: 0, warning: 1, note: 2 };
  const sorted = [...list].sort((a, b) => rank[a.severity] - rank[b.severity]);
  const lines = (part) => element("ul", { class: "checks" }, part.map(finding));
  const rest = sorted.slice(shown);
  return [lines(sorted.slice(0, shown)),
    rest.length ? element("details", {}, element("summary", {}, `and ${rest.length} more`), lines(rest)) : null];
};

// Words between backticks are code.
const marked = (text) => text.split("`").map((part, k) => (k % 2 ? element("code", {}, part) : part));

// Heads of columns of numbers.
const NUMBERS = ["rows", "used", "value ± std"];

const table = (heads, rows, caption) => element("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption },
  element("table", {},
    element("thead", {}, element("tr", {}, heads.map((head) => element("th", { scope: "col", class: NUMBERS.includes(head) ? "num" : null }, head)))),
    element("tbody", {}, rows)));

const cell = (...children) => element("td", {}, ...children);

const option = (value, text, selected) => element("option", { value, selected }, text);

// Seconds as people read them.
const seconds = (s) => (s === null || s === undefined ? "" : String(Math.round(s * 1000) / 1000));

// A handler of the value that a choice comes to rest at: arrow keys pass the ones between.
const settled = (take, pause = 400) => {
  let timer;
  return (e) => {
    const { value } = e.target;
    clearTimeout(timer);
    timer = setTimeout(() => take(value), pause);
  };
};
