// The report: saved beside the campaign, and opened from there.

const report = {
  results: 0,
  name: "",

  setUp() {
    byId("report-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.name = byId("report-name").value;
      attempt("", async () => {
        draw(byId("report-said"));
        await ask("/api/report", {
          name: this.name, replace: byId("report-replace").checked, discovery: byId("report-discovery").checked,
        });
        view.poll();
      });
    });
  },

  follow(progress) {
    work(byId("report-work"), "report", progress);
    byId("report-save").disabled = progress.running;
    if (progress.refusal) return draw(byId("report-said"), progress.refusal.message);
    if (!progress.has_result || progress.results === this.results) return;
    this.results = progress.results;
    const open = element("a", { id: "report-open", href: query("/report", { token }), target: "_blank", rel: "noopener" }, "Open it");
    draw(byId("report-said"), `${this.name} is saved beside the campaign. `, open);
  },
};
