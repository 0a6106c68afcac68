// The fit: it follows every change; measured and simulated motion of a run, parameters, what there is to say.

const fit = {
  // The run that is drawn.
  run: null,
  results: -1,

  setUp() {
    byId("run").addEventListener("change", (event) => {
      this.run = event.target.value;
      this.draw();
    });
  },

  begin() {
    return ask("/api/fit", {}).then(() => view.poll());
  },

  async follow(progress) {
    work(byId("fit-work"), "fit", progress);
    if (progress.refusal) {
      this.results = progress.results;
      // a first look that the campaign's own estimator did not bear out is no result
      this.told = null;
      draw(byId("fit-said"), element("p", { class: "verdict refused" }, marked(progress.refusal.message)));
      for (const id of ["overlay", "parameters"]) draw(byId(id));
      byId("run-choice").hidden = true;
      return draw(byId("fit-findings"), findings(progress.refusal.findings ?? []));
    }
    if (!progress.has_result || progress.results === this.results) return;
    this.results = progress.results;
    const told = await ask("/api/fit");
    if (told) this.show(told);
  },

  show(told) {
    this.told = told;
    const first = told.first_look
      ? element("p", { class: "hint" }, `First look, by ${told.estimator.replaceAll("_", " ")} after ${told.seconds.toFixed(1)} s; the estimator of the campaign is at work.`)
      : element("p", { class: "hint" }, `By ${told.estimator.replaceAll("_", " ")}, in ${told.seconds.toFixed(1)} s.`);
    draw(byId("fit-said"), element("p", { class: "verdict" }, marked(told.sentence)), first);
    if (!told.runs.some((r) => r.run === this.run)) {
      this.run = (told.runs.find((r) => r.role === "validate") ?? told.runs[0])?.run ?? null;
    }
    byId("run-choice").hidden = !told.runs.length;
    const use = { train: "trained", validate: "took no part" };
    draw(byId("run"), told.runs.map((r) => option(r.run, `${r.run} (${use[r.role]})`, r.run === this.run)));
    const symbol = (p) => {
      const made = element("span", { class: "symbol" });
      made.innerHTML = p.symbol;
      return made;
    };
    const row = (p) => element("tr", { class: told.first_look ? "early" : null }, cell(p.common_name), cell(symbol(p)),
      element("td", { class: "num" }, p.text), cell(p.shown_unit), cell(p.fixed ? "held" : ""));
    draw(byId("parameters"), table(["effect", "symbol", "value ± std", "unit", ""], told.parameters.map(row), "Parameters"));
    draw(byId("fit-findings"), findings(told.warnings));
    return this.draw();
  },

  async draw() {
    if (!this.run || !this.told) return draw(byId("overlay"));
    const of = this.told.runs.find((r) => r.run === this.run);
    const said = of.measured.map((m) => `${m.dof} ${Math.max(m.fit_percent, -999).toFixed(0)} %`);
    byId("run-said").textContent = said.length ? `explained: ${said.join(", ")}` : "";
    const told = await ask(query("/api/overlay", { run: this.run })).catch(() => null);
    if (told && told.run === this.run) drawFigures(byId("overlay"), told.figures);
  },
};
