#include "report/page_script.h"

namespace armtrue {

const char* page_script() {
  return R"js((() => {
"use strict";
const all = (where, what) => [...where.querySelectorAll(what)];
const added = (where, tag, set) => where.appendChild(Object.assign(document.createElement(tag), set));

// Tables: a click on a head sorts, the third one restores the order.
const value = row => column => row.cells[column].textContent.trim();
for (const table of all(document, ".scroll>table")) {
  const body = table.tBodies[0], first = [...body.rows], heads = [...table.tHead.rows[0].cells];
  if (first.length < 3) continue;
  heads.forEach((head, column) => {
    if (!head.textContent) return;
    const button = document.createElement("button");
    button.type = "button";
    button.title = "sort";
    button.append(...head.childNodes);
    head.append(button);
    button.onclick = () => {
      const next = {none: "ascending", ascending: "descending"}[head.ariaSort || "none"];
      heads.forEach(other => other.removeAttribute("aria-sort"));
      if (next) head.setAttribute("aria-sort", next);
      const sign = next === "descending" ? -1 : 1;
      const of = row => value(row)(column), number = row => parseFloat(of(row));
      const order = (a, b) =>
        isNaN(number(a)) || isNaN(number(b))
          ? of(a).localeCompare(of(b), "en", {numeric: true}) : number(a) - number(b);
      body.append(...(next ? [...first].sort((a, b) => sign * order(a, b)) : first));
    };
  });
}

// A table that is wider than its place says so.
const hints = all(document, ".scroll").map(place => {
  const hint = document.createElement("p");
  hint.className = "quiet screen";
  hint.textContent = "The table scrolls sideways.";
  place.before(hint);
  return [place, hint];
});
const hint = () => hints.forEach(([place, text]) => text.hidden = place.scrollWidth <= place.clientWidth + 1);
addEventListener("resize", hint);
addEventListener("toggle", hint, true);
hint();

// Spaces: a pointer or the arrow keys turn them, as Panel::projected() does first.
const turned = svg => {
  const frame = svg.querySelector(".turned");
  if (!frame) return;
  let [turn, tilt] = frame.dataset.turn.split(" ").map(Number);
  const [x, y, radius] = frame.dataset.ball.split(" ").map(Number);
  const parts = all(svg, "[data-place]").map(part => [part, part.dataset.place.split(" ").map(Number)]);
  const draw = () => {
    const [c, s, d, e] = [Math.cos(turn), Math.sin(turn), Math.cos(tilt), Math.sin(tilt)];
    const at = (p, k) => {
      const right = c * p[k] - s * p[k + 1], away = s * p[k] + c * p[k + 1];
      return [x + radius * right, y - radius * (d * p[k + 2] + e * away)].map(v => v.toFixed(1));
    };
    for (const [part, p] of parts) {
      const a = at(p, 0);
      if (p.length > 3) part.setAttribute("d", `M${a.join(" ")}L${at(p, 3).join(" ")}`);
      else [part.attributes.x.value, part.attributes.y.value] = a;
    }
  };
  const by = (right, up) => {
    turn += right;
    tilt = Math.min(Math.PI / 2, Math.max(-Math.PI / 2, tilt + up));
    draw();
  };
  turn *= Math.PI / 180;
  tilt *= Math.PI / 180;
  svg.classList.add("space");
  svg.tabIndex = 0;
  svg.onpointerdown = event => svg.setPointerCapture(event.pointerId);
  svg.onpointermove = event => event.buttons && by(-event.movementX / 100, event.movementY / 100);
  svg.onkeydown = event => {
    const way = {ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1]}[event.key];
    if (!way) return;
    event.preventDefault();
    by(...way);
  };
};

// Pictures: the nearest point tells what it is; a click enlarges.
const tip = added(document.body, "div", {id: "tip", hidden: true});
const tells = svg => {
  svg.addEventListener("pointermove", event => {
    const reach = 14;
    let best = null, least = reach * reach;
    for (const mark of all(svg, "[data-tip]")) {
      const box = mark.getBoundingClientRect();
      const dx = Math.max(box.left - event.clientX, 0, event.clientX - box.right);
      const dy = Math.max(box.top - event.clientY, 0, event.clientY - box.bottom);
      // Of marks whose boxes hold the pointer, the one whose middle is nearest.
      const middle = Math.hypot(event.clientX - (box.left + box.right) / 2, event.clientY - (box.top + box.bottom) / 2);
      const distance = dx * dx + dy * dy + 1e-3 * middle;
      if (distance < least) [best, least] = [mark, distance];
    }
    tip.hidden = !best || event.buttons > 0;
    if (!best) return;
    tip.textContent = best.dataset.tip;
    const left = Math.min(event.clientX + 12, innerWidth - tip.offsetWidth - 8);
    tip.style.left = Math.max(4, left) + "px";
    tip.style.top = (event.clientY > 60 ? event.clientY - tip.offsetHeight - 10 : event.clientY + 16) + "px";
  });
  svg.addEventListener("pointerleave", () => tip.hidden = true);
};
// The browser's own tip would come late, and stand over this one.
for (const title of all(document, "path>title,rect>title")) {
  title.parentNode.dataset.tip = title.textContent;
  title.remove();
}
for (const title of all(document, "svg>title")) {
  title.parentNode.setAttribute("aria-label", title.textContent);
  title.remove();
}
const dialog = added(document.body, "dialog", {ariaLabel: "The picture, enlarged"});
dialog.onclick = event => event.target === dialog && dialog.close();
for (const figure of all(document, "figure")) {
  const svg = figure.querySelector("svg");
  if (!svg) continue;
  const enlarge = () => {
    const copy = figure.cloneNode(true);
    all(copy, "button").forEach(button => button.remove());
    const close = added(copy, "button", {type: "button", textContent: "close"});
    close.onclick = () => dialog.close();
    dialog.replaceChildren(copy);
    const large = copy.querySelector("svg");
    turned(large);
    tells(large);
    dialog.append(tip);
    dialog.showModal();
  };
  turned(svg);
  tells(svg);
  const button = added(figure, "button", {type: "button", textContent: "enlarge"});
  button.setAttribute("aria-label", "Enlarge: " + svg.getAttribute("aria-label"));
  button.onclick = enlarge;
  if (!svg.querySelector(".turned")) svg.addEventListener("click", enlarge);
}
dialog.onclose = () => document.body.append(tip);
})();
)js";
}

}  // namespace armtrue
