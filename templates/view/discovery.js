// Discovery: the search with its progress, what it says, and taking a name into the campaign.

const discovery = {
  results: 0,

  setUp() {
    byId("discover").addEventListener("click", () => attempt("", async () => {
      await ask("/api/discovery", {});
      view.poll();
    }));
  },

  async follow(progress) {
    work(byId("discovery-work"), "discovery", progress);
    byId("discover").disabled = progress.running;
    if (progress.refusal) {
      return draw(byId("discovery-said"), element("p", { class: "verdict refused" }, marked(progress.refusal.message)), findings(progress.refusal.findings ?? []));
    }
    if (!progress.has_result || progress.results === this.results) return;
    this.results = progress.results;
    this.told = await ask("/api/discovery");
    this.show();
  },

  // The result; names that stand in the model by now have no button.
  show() {
    const told = this.told;
    if (!told) return;
    const on = new Set(view.campaign.effects.flatMap((f) => f.effects.flatMap((e) => e.places.filter((p) => p.on).map((p) => p.name))));
    const adopt = (id) => {
      if (on.has(id)) return element("span", { class: "in" }, "in the model");
      return element("button", {
        type: "button", class: "main", id: `adopt-${id}`, onclick: () => change("/api/adopt", { name: id }),
      }, `Adopt ${id}`);
    };
    const effect = (e) => element("li", {}, element("div", {}, element("b", {}, e.common_name), " ", element("code", {}, e.id)),
      element("p", {}, marked(`${e.evidence}.`)),
      e.also_possible.length ? element("p", { class: "hint" }, `Also possible: ${e.also_possible.join(", ")}`) : null, adopt(e.id));
    const others = told.adopt.filter((id) => !told.effects.some((e) => e.id === id));
    const stale = told.stamp !== view.campaign.stamp
      ? element("p", { class: "hint" }, "The campaign has changed since this search.") : null;
    const figure = element("div", { class: "figures" });
    if (told.figure) drawFigures(figure, [told.figure]);
    draw(byId("discovery-said"), element("p", { class: "verdict" }, marked(told.sentence)), stale,
      told.effects.length ? element("ul", { class: "found" }, told.effects.map(effect)) : null,
      others.length ? element("div", { class: "row" }, others.map(adopt)) : null,
      told.behaves_like.map((text) => element("p", {}, marked(`Something ${text}.`))),
      told.next_experiment ? element("p", {}, marked(`Next: ${told.next_experiment}`)) : null, figure, findings(told.warnings));
  },
};
