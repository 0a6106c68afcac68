// Columns: what each column of the chosen log is taken for, with the light that the check gives it.

const columns = {
  async show(campaign, file) {
    byId("columns").hidden = !file;
    if (!file) return;
    const told = await ask(query("/api/columns", { log: file }));
    if (file !== logs.chosen) return;
    draw(byId("columns-of"), `of ${file}`);
    const units = Object.fromEntries(told.channels.map((c) => [c.name, c.units]));
    const parts = told.files.map((part, f) => [
      told.files.length > 1 ? element("h3", {}, part.file) : null,
      table(["", "column", "first values", "is", "in", "counts the other way"],
        part.columns.map((column, k) => this.row(file, f, k, column, told.channels, units)), `Columns of ${part.file}`),
      element("p", { class: "hint" }, part.options === "[log]"
        ? "Written into [log] of the campaign where all logs have the column, else into a table of this log."
        : "This log has reading options of its own."),
    ]);
    draw(byId("column-list"), parts, findings(told.findings, 6));
  },

  row(log, file, k, column, channels, units) {
    const id = `column-${file}-${k}`, name = column.header;
    const known = channels.some((c) => c.name === column.channel);
    const set = (changed) => change("/api/columns", {
      log, file, header: name, channel: known ? column.channel : "", unit: column.unit || null, flipped: column.sign < 0, ...changed,
    });
    const meaning = element("select", {
      id: `${id}-is`, "aria-label": `${name} is`, onchange: settled((channel) => set({ channel, unit: null })),
    }, option("", known ? "kept under its own name" : `${column.channel} (its own name)`, !known),
    channels.map((c) => option(c.name, c.name, c.name === column.channel)));
    const choices = [...new Set([...(units[column.channel] ?? []), column.unit].filter(Boolean))];
    const unit = choices.length < 2 ? (column.unit || "–") : element("select", {
      id: `${id}-unit`, "aria-label": `Unit of ${name}`, onchange: settled((unit) => set({ unit })),
    }, choices.map((u) => option(u, u, u === column.unit)));
    const flip = column.channel === "t" ? null : element("input", {
      type: "checkbox", id: `${id}-flip`, "aria-label": `${name} counts the other way`, checked: column.sign < 0,
      onchange: (e) => set({ flipped: e.target.checked }),
    });
    const said = column.findings.map((f) => element("div", { class: "said" }, marked(f.message), " ", element("code", {}, f.code)));
    const colour = column.known || column.findings.length ? column.light : null;
    return element("tr", {}, cell(light(colour, name)), cell(element("b", {}, name), said),
      element("td", { class: "samples" }, column.samples.join("  ")), cell(meaning), cell(unit),
      cell(flip, flip ? element("label", { for: flip.id }, " counts the other way") : null));
  },
};
