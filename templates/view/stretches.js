// Stretches: which part of a log trains the model and which judges it, on the plot and in numbers.

const stretches = {
  // Which stretch a drag sets: its run, or "new".
  target: "new",
  ends: [0, 0],
  newRole: "validate",

  setUp() {
    for (const id of ["plot-channel", "plot-below"]) byId(id).addEventListener("change", () => this.draw(logs.chosen));
    byId("plot").addEventListener("stretch", (event) => {
      event.preventDefault();
      const round = (s) => Math.round(s * 100) / 100;
      this.set(this.target, { from: round(event.detail.from), to: round(event.detail.to) });
    });
  },

  of(campaign, file) {
    return campaign.logs.find((log) => log.file === file)?.stretches ?? [];
  },

  set(target, changed) {
    const list = this.of(view.campaign, logs.chosen);
    if (target === "new") {
      const stretch = { role: this.newRole, from: null, to: null, ...changed };
      return change("/api/stretch/add", { run: list[list.length - 1].run, stretch });
    }
    const { role, from, to } = list.find((s) => String(s.run) === target);
    return change("/api/stretch", { run: Number(target), stretch: { role, from, to, ...changed } });
  },

  async show(campaign, file) {
    byId("stretches").hidden = !file;
    if (!file) return;
    draw(byId("stretches-of"), `of ${file}`);
    const list = this.of(campaign, file);
    if (this.target !== "new" && !list.some((s) => String(s.run) === this.target)) this.target = "new";
    if (list.length === 1) this.target = String(list[0].run);
    // the rows of the log before are not to be taken for those of this one
    this.ends = [null, null];
    this.rows(list);
    await this.draw(file);
    if (file === logs.chosen) this.rows(this.of(view.campaign, file));
  },

  async draw(file) {
    let told;
    try {
      told = await ask(query("/api/plot", { log: file, channel: byId("plot-channel").value, below: byId("plot-below").value }));
    } catch (refusal) {
      return draw(byId("plot"), element("p", { class: "note" }, refusal.message));
    }
    if (file !== logs.chosen) return;
    const choose = (id, value, extra) => draw(byId(id), extra, told.channels.map((c) => option(c, c, c === value)));
    choose("plot-channel", told.channel);
    choose("plot-below", told.below, option("-", "nothing", told.below === "-"));
    this.ends = [told.from, told.to];
    const box = byId("plot");
    box.innerHTML = told.figure;
    told.roles.forEach((role, k) => box.querySelectorAll(`[data-span="${k}"]`).forEach((span) => span.classList.add(role)));
    charts.adorn(box);
  },

  rows(list) {
    const [first, last] = this.ends;
    const roles = (id, role, set) => element("select", { id, "aria-label": "Use", onchange: (e) => set(e.target.value) },
      option("train", "trains", role === "train"), option("validate", "judges", role === "validate"));
    const target = (value, label) => element("input", {
      type: "radio", name: "target", id: `target-${value}`, value, checked: this.target === value, "aria-label": label,
      onchange: () => { this.target = value; },
    });
    const row = (s, k) => {
      const number = (key, usual) => element("input", {
        type: "number", step: "any", id: `stretch-${k}-${key}`, "aria-label": key === "from" ? "From, s" : "To, s",
        value: seconds(s[key]), placeholder: seconds(usual), inputmode: "decimal",
        onchange: (e) => this.set(String(s.run), { [key]: e.target.value === "" ? null : Number(e.target.value) }),
      });
      const remove = element("button", {
        type: "button", id: `stretch-${k}-remove`, disabled: view.campaign.logs.length === 1 && list.length === 1,
        "aria-label": `Remove stretch ${k + 1}`, onclick: () => change("/api/stretch/remove", { run: s.run }),
      }, "Remove");
      const where = s.where ? element("div", { class: "said" }, `where ${s.where}`) : null;
      return element("tr", {}, cell(target(String(s.run), `A drag sets stretch ${k + 1}`)),
        cell(roles(`stretch-${k}-role`, s.role, (role) => this.set(String(s.run), { role })), where),
        cell(number("from", first)), cell(number("to", last)), cell(remove));
    };
    const value = (id) => (byId(id).value === "" ? null : Number(byId(id).value));
    const fresh = element("tr", { class: "fresh" }, cell(target("new", "A drag makes a new stretch")),
      cell(roles("new-stretch-role", this.newRole, (role) => { this.newRole = role; })),
      cell(element("input", { type: "number", step: "any", id: "new-stretch-from", "aria-label": "From, s, of a new stretch", placeholder: seconds(first) })),
      cell(element("input", { type: "number", step: "any", id: "new-stretch-to", "aria-label": "To, s, of a new stretch", placeholder: seconds(last) })),
      cell(element("button", {
        type: "button", id: "new-stretch-add",
        onclick: () => this.set("new", { from: value("new-stretch-from"), to: value("new-stretch-to") }),
      }, "Add")));
    draw(byId("stretch-list"), table(["drag", "use", "from, s", "to, s", ""], [...list.map(row), fresh], "Stretches"));
  },
};
