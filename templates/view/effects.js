// Effects: what the model may hold, switched on and off.

const effects = {
  // Families that were opened or closed by hand.
  open: {},

  setUp() {
    byId("find-effect").addEventListener("input", () => this.filter());
  },

  show(campaign) {
    const family = (f) => {
      const on = f.effects.reduce((all, e) => all + e.places.filter((p) => p.on).length, 0);
      const details = element("details", { open: this.open[f.family] ?? (f.family === "body" || on > 0), "data-family": f.family },
        element("summary", { id: `family-${f.family.replace(/\W/g, "-")}` }, f.family, " ", element("span", { class: "count" }, on ? `${on} in the model` : "")),
        f.effects.map((e) => this.row(e)));
      details.addEventListener("toggle", () => { if (!byId("find-effect").value) this.open[f.family] = details.open; });
      return details;
    };
    draw(byId("effect-list"), campaign.effects.map(family));
    this.filter();
  },

  row(effect) {
    const places = effect.places.map((place) => {
      const box = element("input", {
        type: "checkbox", id: `effect-${place.name}`, checked: place.on,
        onchange: (e) => change("/api/effect", { name: place.name, on: e.target.checked }),
      });
      const label = place.place || "in the model";
      return element("label", { class: "tick" }, box, ` ${label}`, element("span", { class: "unseen" }, `, ${effect.common_name}`));
    });
    return element("div", { class: "effect", "data-words": `${effect.id} ${effect.common_name} ${effect.meaning}`.toLowerCase() },
      element("div", { class: "name", title: `${effect.meaning}\n${effect.formula}` }, effect.common_name, " ", element("code", {}, effect.id)),
      element("div", { class: "places" }, places));
  },

  filter() {
    const wanted = byId("find-effect").value.trim().toLowerCase().split(/\s+/).filter(Boolean);
    for (const family of byId("effect-list").querySelectorAll("details")) {
      let any = false;
      for (const row of family.querySelectorAll(".effect")) {
        row.hidden = !wanted.every((word) => row.dataset.words.includes(word));
        any ||= !row.hidden;
      }
      family.hidden = !any;
      if (wanted.length && any) family.open = true;
    }
  },
};
